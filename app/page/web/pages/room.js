// Lets the buttons of the shared page answer for this browser: a vote, with a random number that replaces its own earlier one, or a hand.
({hand, vote, option, counted}) => {
  const lab = window.observerLabRoom ??= {kept: {}};
  const read = key => { try { return localStorage.getItem(key); } catch (error) { return lab.kept[key] ?? null; } };
  const write = (key, value) => { lab.kept[key] = value; try { localStorage.setItem(key, value); } catch (error) { console.warn('not kept', error); } };
  const mark = () => {
    const style = document.getElementById('ol-voted') ?? document.head.appendChild(Object.assign(document.createElement('style'), {id: 'ol-voted'}));
    const chosen = read('observer-lab-voted');
    style.textContent = chosen ? `.ol-option[data-room="${CSS.escape(chosen)}"]{outline:3px solid var(--ol-accent)}` : '';
  };
  if (hand) lab.hand = hand;
  if (vote !== undefined && counted) write('observer-lab-voted', `vote:${vote}:${option}`);
  mark();
  if (lab.listens) return;
  lab.listens = true;
  const ballot = number => {  // a new one for each vote: two votes of one browser cannot be told to be of one
    const [of, word] = (read('observer-lab-ballot') ?? '').split(':');
    if (of === number) return word;
    const drawn = [...crypto.getRandomValues(new Uint8Array(16))].map(byte => byte.toString(16).padStart(2, '0')).join('');
    write('observer-lab-ballot', `${number}:${drawn}`);
    return drawn;
  };
  document.addEventListener('click', event => {
    const pressed = event.target?.closest?.('button[data-room]:enabled');
    if (!pressed) return;
    const [kind, number] = pressed.dataset.room.split(':');
    const typed = pressed.dataset.answer ?? pressed.parentElement.querySelector('input')?.value;
    if (typed === '') return;
    const value = number === undefined ? kind : [pressed.dataset.room, ...(typed === undefined ? [] : [typed]), ballot(number)].join(':');
    window.observerLabViser.tell(lab.hand, value);
  });
}
