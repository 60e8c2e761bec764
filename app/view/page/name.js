// What the browser's own tab is called, and the language that a screen reader speaks.
({title, language}) => {
  document.title = title;
  document.documentElement.lang = language;
}
