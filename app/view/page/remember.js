// Keeps a text in this tab alone, through a reload; a browser without storage, or with a full one, keeps nothing.
({key, text}) => {
  try { sessionStorage.setItem(key, text); } catch (error) { console.warn('not kept', error); }
}
