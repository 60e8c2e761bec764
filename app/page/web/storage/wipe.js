// Takes away all that this browser kept: of this tab, of those before it, and the designs with names.
({keys}) => {
  for (const store of ['sessionStorage', 'localStorage']) for (const key of keys) {
    try { window[store].removeItem(window.observerLabAddress?.own(key) ?? key); } catch (error) { console.warn('no storage', error); }
  }
  window.observerLabKept = {};
}
