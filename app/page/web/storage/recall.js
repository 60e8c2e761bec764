// Answers with what this tab kept, what stands in its address bar, what the tabs before it kept, the designs with names,
// how large its window is and whether its owner likes the dark, and its own .zip of lessons, in the shape of viser's one answer about
// storage.
({key, shelf, lessons, most, request}) => {
  const lab = window.observerLabAddress, token = lab?.token() ?? '';
  const read = (store, name) => { try { return window[store].getItem(name); } catch (error) { console.warn('no storage', error); return null; } };
  const own = name => lab?.own(name) ?? name;
  const kept = read('sessionStorage', own(key)), earlier = read('localStorage', own(key));
  try {
    window.observerLabKept = Object.fromEntries(Object.entries(JSON.parse(kept ?? earlier ?? '{}').desks ?? {})
      .map(([name, written]) => [name, JSON.stringify(written)]));
  } catch (error) { window.observerLabKept = {}; }
  const home = location.origin + location.pathname;
  const told = [kept, token, token === lab?.shown, home, kept === null ? earlier : null, read('localStorage', own(shelf)),
    [innerWidth, innerHeight, matchMedia('(prefers-color-scheme: dark)').matches],
    read('sessionStorage', own(lessons))];
  const heavy = () => new Blob([JSON.stringify(told)]).size > most;  // a larger message would cost the connection
  for (const less of [7, 5, 4, 0]) if (heavy()) told[less] = null;
  const value = JSON.stringify(told);
  window.observerLabViser.answerStorage(request, value);
}
