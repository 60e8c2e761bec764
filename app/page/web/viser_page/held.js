// Runs before viser's page: keeps what a hand has done until the server has answered it, and does it again after an outage. Widgets have
// new names on a new connection, so each is known by its kind, its label and its place among those alike.
({kept}) => {
  const viser = window.observerLabViser, line = window.observerLabLine;
  const lesson = () => history.state?.observerLab ?? '';
  const CHANGE = 'GuiUpdateMessage', DRAG = 'SceneNodeDragMessage', COMMAND = 'CommandTriggerMessage', WAIT = 60, LONGEST = 40000;  // ms
  const PRESSES = ['GuiButtonGroupMessage', 'GuiButtonMessage', COMMAND];  // which do something each time; all else sets a value
  const named = new Map(), gone = new Map(), GONE = 2000;  // uuid → what the widget is, or was before the page was laid out anew; how many
  const store = list => { try { sessionStorage.setItem(kept, JSON.stringify(list)); } catch (error) { console.warn('not kept', error); } };
  const stored = () => { try { return JSON.parse(sessionStorage.getItem(kept) ?? '[]'); } catch (error) { return []; } };
  const sent = new Map(), SENT = 50;  // number → a press on its way, or done; how many
  let held = stored(), count = held.length, owner = '', returns = false;
  held.forEach((each, k) => { each.count = k + 1; });
  const layAside = uuid => {
    if (named.has(uuid)) gone.set(uuid, named.get(uuid));
    named.delete(uuid);
    if (gone.size > GONE) gone.delete(gone.keys().next().value);
  };

  line.unanswered = () => (held.length && !returns ? held.at(-1).count : null);
  line.answered = number => {
    if (returns) return;
    held = held.filter(each => each.count > number);
    store(held);
  };
  line.take = messages => {
    for (const message of messages) {
      if (message.type === 'GuiRemoveMessage') layAside(message.uuid);
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
    const late = !named.has(message.uuid) && gone.has(message.uuid), widget = (late ? gone : named).get(message.uuid);
    const press = widget && PRESSES.includes(widget.kind);
    const counts = message.type === DRAG || message.type === COMMAND || (message.type === CHANGE && 'value' in (message.updates ?? {}));
    const hand = counts && (message.type === DRAG || !!widget && (press || !widget.hidden));
    const goes = !line.lost && !(hand && (returns || late));
    if (hand) {
      const key = widget?.key ?? message.name, part = message.type === DRAG ? message.phase : press ? `press ${count}` : '';
      const entry = {count: count += 1, key, part, press, message, lesson: lesson(), unsent: !goes};
      if (part === 'start') held = held.filter(each => each.key !== key);
      held = [...held.filter(each => !alike(each, entry)), entry];
      store(held);
      if (press && goes) sent.set(count, entry).delete(count - SENT);
      if (late && !line.lost && !returns) redo(each => each === entry);
    }
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
    if (!widget || widget[0] === entry.missed) return null;
    const [uuid, {kind, hidden}] = widget;
    return hidden && kind === PRESSES[0] && !isAsked(String(message.updates.value)) ? null : {...message, uuid};
  };
  const redo = async chosen => {  // once the page stands; what a hand does until then comes behind
    const end = performance.now() + LONGEST;
    returns = true;
    while (!stands() && !line.lost && performance.now() < end) await new Promise(done => { setTimeout(done, WAIT); });
    returns = false;
    if (line.lost || !stands()) return;
    const entries = held.filter(each => each.unsent || chosen(each)).map(entry => [entry, again(entry)]).filter(([, message]) => message);
    for (const [entry, message] of entries) {
      if (message.type === CHANGE && !PRESSES.includes(named.get(message.uuid)?.kind)) viser.show([message]);  // the slider as well
      if (entry.press) number(entry.count);
      Object.assign(entry, {unsent: false, message});
      if (entry.press) sent.set(entry.count, entry);
      viser.send(message);
    }
    store(held);
  };
  line.onReturn = () => {
    [...named.keys()].forEach(layAside);
    sent.clear();
    owner = '';
    redo(() => true);
  };
  line.missed = (uuid, last) => {  // the widget had gone, since the page was being laid out anew
    const entry = [sent.get(last), ...held].find(each => each && !each.unsent && each.message.uuid === uuid);
    if (!entry) return;
    const turns = /^turn/.test(entry.message.updates?.value);  // from wherever the page is
    Object.assign(entry, {count: count += 1, unsent: true, missed: uuid, lesson: turns ? '' : entry.lesson});
    held = [...held.filter(each => each !== entry), entry];
    if (!returns) redo(() => false);
  };
}
