// Shows the speaker's notes in a window of their own, with a clock and, where a class follows, its counts, votes and buttons; while it is
// open they leave the page that the hall sees. Its keys turn the scenes of that page, as a clicker's do there.
({hand, title, note, next, begin, end, minutes, words, room, ask}) => {
  const lab = window.observerLabNotes ??= {began: null, view: null, room: '', ask: ''}, viser = window.observerLabViser;
  const told = Object.entries({hand, title, note, next, begin, end, minutes, words, room, ask});  // of the scene, or of the class
  Object.assign(lab, Object.fromEntries(told.filter(([, value]) => value !== undefined)));
  const TURNS = {ArrowRight: 1, PageDown: 1, ' ': 1, ArrowLeft: -1, PageUp: -1};
  const turn = event => {
    const by = TURNS[event.key];
    if (!by || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    viser.tell(lab.hand, `turn:${by}`);
  };
  const typing = target => target?.closest?.('input,textarea,select,button,summary,a,[role],[tabindex]');
  const presents = () => {  // a page that is being laid out is what it was
    if (document.querySelector('.ol-head')) lab.presents = !!document.querySelector('.ol-present');
    return lab.presents;
  };
  lab.write = () => {
    const there = !!lab.view && !lab.view.closed, root = document.documentElement;
    root.classList.toggle('ol-speaks', there);
    if (!there) return;
    const find = id => lab.view.document.getElementById(id), put = (id, text) => { if (find(id).textContent !== text) find(id).textContent = text; };
    const gone = Math.floor((performance.now() - lab.began) / 1000), minutes = gone / 60, {words} = lab;
    const late = minutes > lab.end ? minutes - lab.end : Math.min(minutes - lab.begin, 0), whole = Math.max(Math.round(Math.abs(late)), 1);
    put('title', lab.title);
    put('note', lab.note);
    put('next', lab.next ? `${words.next}: ${lab.next}` : '');
    put('clock', `${Math.floor(gone / 60)}:${String(gone % 60).padStart(2, '0')} / ${lab.minutes} min`);
    put('pace', Math.abs(late) < .5 ? words.onTime : (late > 0 ? words.behind : words.ahead).replace('#', whole));
    for (const part of ['room', 'ask']) {
      if (find(part).dataset.said === lab[part]) continue;
      find(part).innerHTML = find(part).dataset.said = lab[part];
    }
  };
  lab.open ??= () => {
    lab.view = window.open('', 'observer-lab-notes', 'width=720,height=640');
    if (!lab.view) return;
    lab.began ??= performance.now();
    const page = lab.view.document, made = (tag, id) => Object.assign(page.createElement(tag), {id});
    page.title = lab.words.notes;
    Object.assign(page.documentElement, {lang: document.documentElement.lang}).dataset.olTheme = document.documentElement.dataset.olTheme;
    page.head.replaceChildren(...[...document.querySelectorAll('style')].filter(each => each.textContent.includes('.ol-do'))
      .map(each => page.importNode(each, true)));
    page.body.className = 'ol-console';
    page.body.replaceChildren(...[['h1', 'title'], ['p', 'clock'], ['p', 'pace'], ['p', 'note'], ['p', 'next'], ['div', 'room'], ['div', 'ask']]
      .map(([tag, id]) => made(tag, id)));
    page.onkeydown = event => { if (!typing(event.target)) turn(event); };
    page.onclick = event => {
      const pressed = event.target?.closest?.('button:enabled'), field = pressed?.dataset.asks && pressed.parentElement.querySelector('textarea');
      if (pressed?.dataset.to) viser.tell(pressed.dataset.to, pressed.dataset.value);
      if (!field) return;
      viser.tell(pressed.dataset.asks, `${pressed.dataset.kind}:${field.value}`);
      field.value = '';
    };
    lab.timer ??= setInterval(() => lab.write(), 500);
    lab.write();
  };
  if (!lab.listens) {
    lab.listens = true;
    document.addEventListener('click', event => { if (event.target?.closest?.('.ol-notes')) lab.open(); });
    document.addEventListener('keydown', event => {  // of a clicker: an arrow on a widget is the widget's
      if (event.key !== ' ' && presents() && !typing(event.target)) turn(event);
    });
  }
  lab.write();
}
