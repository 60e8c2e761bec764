// What the browser's own tab is called, and the language that a screen reader and the next loading screen speak.
({title, language, kept}) => {
  document.title = title;
  document.documentElement.lang = language;
  try { sessionStorage.setItem(kept, language); } catch (error) { console.warn('not kept', error); }
}
