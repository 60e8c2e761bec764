// Answers with what this tab kept and what stands in its address bar, in the shape of viser's one answer about storage.
({key, request}) => {
  const lab = window.observerLabAddress, token = lab?.token() ?? '';
  let kept = null;
  try { kept = sessionStorage.getItem(key); } catch (error) { console.warn('no storage', error); }
  const value = JSON.stringify([kept, token, token === lab?.shown, location.origin + location.pathname]);
  window.__viserMutable.sendMessage({type: 'LocalStorageGetItemResponseMessage', value, error: null, request_uuid: request});
}
