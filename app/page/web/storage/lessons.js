// Keeps a .zip of lessons for this tab alone, through a reload; none where there are no words.
({key, words}) => {
  const own = window.observerLabAddress?.own(key) ?? key;
  try {
    sessionStorage.removeItem(own);
    if (words) sessionStorage.setItem(own, words);
  } catch (error) { console.warn('not kept', error); }
}
