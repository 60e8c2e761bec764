// Puts a design under a name into the browser's own storage, or takes it away where there are no words; what other tabs have put
// there stays.
({key, under, words}) => {
  const own = window.observerLabAddress?.own(key) ?? key;
  try {
    const {[under]: before, ...others} = JSON.parse(localStorage.getItem(own) ?? '{}');
    localStorage.setItem(own, JSON.stringify(words ? {...others, [under]: words} : others));
  } catch (error) { console.warn('not kept', error); }
}
