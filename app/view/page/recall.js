// Answers with what this tab kept, in the shape of the one answer about storage that viser knows.
({key, request}) => {
  let value = null;
  try { value = sessionStorage.getItem(key); } catch (error) { console.warn('no storage', error); }
  window.__viserMutable.sendMessage({type: 'LocalStorageGetItemResponseMessage', value, error: null, request_uuid: request});
}
