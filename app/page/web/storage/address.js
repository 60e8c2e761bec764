// Runs before viser's page: what stands behind # in the address bar is a state. It never leaves the browser by itself.
// What stands behind ? does not stay: an access token, or a server that viser's page would connect to instead of ours.
({kept}) => {
  const folder = location.pathname.replace(/[^/]*$/, '');
  const own = key => key + (folder === '/' ? '' : folder);  // labs under other paths of this host are other people's, as on a hub
  const store = () => { try { return sessionStorage.getItem(own(kept)) ?? ''; } catch (error) { return ''; } };
  const viser = window.observerLabViser;
  const LINK = own(kept + '-link');  // what was opened and not yet taken: a page that is loaded again meanwhile opens it again
  let here = '';  // where the browser refuses storage, as in frames of other sites
  const held = value => {
    here = value ?? here;
    try {
      if (value !== undefined) sessionStorage.setItem(LINK, value);
      return sessionStorage.getItem(LINK) ?? '';
    } catch (error) { return here; }
  };
  const anew = performance.getEntriesByType('navigation')[0]?.type === 'reload';
  const carried = held(location.hash || (anew ? held() : ''));
  const lab = window.observerLabAddress = {own, shown: store(), asked: 0, widget: '', carried};
  const plain = () => {
    const asked = new URLSearchParams(location.search);
    for (const name of ['token', 'present', 'again', 'place', 'websocket']) asked.delete(name);
    return location.pathname + (asked.size ? '?' + asked : '');
  };
  const asked = new URLSearchParams(location.search), role = ['own', 'follow'].find(name => asked.has(name));  // in a lecture room
  if (asked.get('view') === 'stage') document.documentElement.dataset.olView = 'stage';  // the picture alone, for a frame
  const launch = asked.get('lti');  // of a learning platform
  // viser's page leaves the last / out, at which proxies turn away
  viser.server = location.origin.replace(/^http/, 'ws') + folder + (role ? `?${role}=1` : launch ? '?lti=' + encodeURIComponent(launch) : '');
  lab.token = () => (lab.carried || location.hash).slice(1);
  lab.say = what => viser.tell(lab.widget, JSON.stringify(what));
  lab.show = (token, lesson, asked, answered) => {
    if (asked < lab.asked) return;  // an answer from before the last state that was opened here
    const old = history.state?.observerLab, other = old !== undefined && old !== lesson;
    history[other ? 'pushState' : 'replaceState']({observerLab: lesson}, '', plain() + (token && '#' + token));
    lab.shown = token;
    held('');
    if (token) window.observerLabLine?.answered(answered);  // it holds these presses: after an outage they are not done again
    try { sessionStorage.setItem(own(kept), token); } catch (error) { console.warn('not kept', error); }
  };
  addEventListener('hashchange', () => {
    const token = location.hash.slice(1);
    if (token && token !== lab.shown && lab.widget) lab.say({open: token, asked: ++lab.asked});
  });
  history.replaceState(history.state, '', plain());  // viser's page would take the rest for a part of the server's address
  viser.onConnecting = () => {
    history.replaceState(history.state, '', plain() + (lab.carried || location.hash));  // where viser's page has put its server
    lab.carried = '';
  };
}
