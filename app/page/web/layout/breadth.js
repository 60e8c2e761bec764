// Runs before viser's page: its sheet for phones lies in every window that has no room for two columns beside the stage. `page.css`
// and `print_sizes.py` say the same.
() => {
  window.observerLabViser.sheetWithin('(max-width: 56em)');
}
