// Runs before viser's page: keeps what a hand has done until the server has answered it, and does it again after an outage. Widgets have
// new names on a new connection, so each is known by its kind, its label and its place among those alike.
({kept}) => {
  const viser = window.observerLabViser, line = window.observerLabLine, address = () => window.observerLabAddress?.shown ?? '';
  const lesson = () => history.state?.observerLab ?? '';
  const CHANGE = 'GuiUpdateMessage', DRAG = 'SceneNodeDragMessage', COMMAND = 'CommandTriggerMessage', WAIT = 60, LONGEST = 40000;  // ms
  const PRESSES = ['GuiButtonGroupMessage', 'GuiButtonMessage', COMMAND];  // which do something each time; all else sets a value
  const named = new Map();  // uuid → what the widget is
  const store = list => { try { sessionStorage.setItem(kept, JSON.stringify(list)); } catch (error) { console.warn('not kept', error); } };
  const stored = () => { try { return JSON.parse(sessionStorage.getItem(kept) ?? '[]'); } catch (error) { return []; } };
  let held = stored(), count = held.length, owner = '', returns = false;
  held.forEach((each, k) => { each.count = k + 1; });

  line.unanswered = () => (held.length && !returns ? held.at(-1).count : null);
  line.answered = number => {
    if (returns) return;
    held = held.filter(each => each.count > number);
    store(held);
  };
  line.take = messages => {
    for (const message of messages) {
      if (message.type === 'GuiRemoveMessage') named.delete(message.uuid);
      else if (message.uuid && message.props && !named.has(message.uuid)) {
        const kind = message.type === 'RegisterCommandMessage' ? COMMAND : message.type, like = `${kind}|${message.props.label ?? ''}|`;
        const place = [...named.values()].filter(each => each.like === like).length;
        named.set(message.uuid, {like, key: like + place, kind, hidden: message.props.visible === false});
      }
      if (message.owner) owner = message.owner;
    }
  };
  const number = count => viser.send({type: 'LocalStorageGetItemResponseMessage', value: null, error: null, request_uuid: `press:${count}`});
  const alike = (one, other) => one.key === other.key && one.part === other.part;
  viser.onSend = message => {  // whether it goes to the server now
    const widget = named.get(message.uuid), press = widget && PRESSES.includes(widget.kind);
    const counts = message.type === DRAG || message.type === COMMAND || (message.type === CHANGE && 'value' in (message.updates ?? {}));
    const hand = counts && (message.type === DRAG || !!widget && (press || !widget.hidden));
    if (hand) {
      const key = widget?.key ?? message.name, part = message.type === DRAG ? message.phase : press ? `press ${count}` : '';
      const entry = {count: count += 1, key, part, press, message, at: address(), lesson: lesson()};
      if (part === 'start') held = held.filter(each => each.key !== key);
      held = [...held.filter(each => !alike(each, entry)), entry];
      store(held);
    }
    const goes = !line.lost && !(hand && returns);
    if (goes && hand && press) number(count);
    return goes;
  };
  const stands = () => {  // the page of this connection
    const mark = document.querySelector('.ol-mark');
    if (mark) return mark.dataset.stands === '1' && named.has(mark.dataset.ask);
    return !!document.querySelector('.ol-card') && named.size > 0;
  };
  const isAsked = value => /^(turn|slower|ask|pole)\b/.test(value) ||  // whether a button of ours that says this is still there
    [...document.querySelectorAll('button[data-to],button[data-room]')].some(({dataset}) =>
      dataset.value === value || (dataset.room && value.startsWith(dataset.room)));
  const again = entry => {
    const {message, key} = entry, widget = [...named].find(([, each]) => each.key === key);
    if (entry.lesson && entry.lesson !== lesson()) return null;  // a page that was cut off early was not yet told its lesson
    if (message.type === DRAG) return viser.node(message.name) ? {...message, owner} : null;
    if (!widget) return null;
    const [uuid, {kind, hidden}] = widget, done = entry.press && entry.at !== address();  // its answer was kept, though not seen
    return done || (hidden && kind === PRESSES[0] && !isAsked(String(message.updates.value))) ? null : {...message, uuid};
  };
  line.onReturn = async () => {
    named.clear();
    owner = '';
    if (!held.length) return;
    returns = true;
    const end = performance.now() + LONGEST;
    while (!stands() && !line.lost && performance.now() < end) await new Promise(done => { setTimeout(done, WAIT); });
    returns = false;
    if (line.lost || !stands()) return;
    const entries = held.map(entry => [entry, again(entry)]).filter(([, message]) => message);
    for (const [{press, count}, message] of entries) {
      if (message.type === CHANGE && !PRESSES.includes(named.get(message.uuid)?.kind)) viser.show([message]);  // the slider as well
      if (press) number(count);
      viser.send(message);
    }
  };
}
