// Runs before viser's page: what stands behind # in the address bar is a state. It never leaves the browser by itself.
({kept}) => {
  const store = () => { try { return sessionStorage.getItem(kept) ?? ''; } catch (error) { return ''; } };
  const lab = window.observerLabAddress = {shown: store(), asked: 0, widget: '', carried: location.hash};
  const plain = () => location.pathname + location.search;
  lab.token = () => (lab.carried || location.hash).slice(1);
  lab.say = what => window.__viserMutable.sendMessage({type: 'GuiUpdateMessage', uuid: lab.widget, updates: {value: JSON.stringify(what)}});
  lab.show = (token, lesson, asked) => {
    if (asked < lab.asked) return;  // an answer from before the last state that was opened here
    const old = history.state?.observerLab, other = old !== undefined && old !== lesson;
    history[other ? 'pushState' : 'replaceState']({observerLab: lesson}, '', plain() + (token && '#' + token));
    lab.shown = token;
    try { sessionStorage.setItem(kept, token); } catch (error) { console.warn('not kept', error); }
  };
  addEventListener('hashchange', () => {
    const token = location.hash.slice(1);
    if (token && token !== lab.shown && lab.widget) lab.say({open: token, asked: ++lab.asked});
  });
  if (!location.hash) return;
  history.replaceState(history.state, '', plain());  // viser's page would take it for a part of the server's address
  window.Worker = class extends Worker {
    constructor(...how) {
      super(...how);
      if (!lab.carried) return;
      history.replaceState(history.state, '', plain() + lab.carried);
      lab.carried = '';
    }
  };
}
