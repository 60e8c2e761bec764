// Shows the speaker's notes in a window of their own, with a clock; its keys turn the scenes of the page that opened it.
({hand, note, title, next, minutes, words}) => {
  const lab = window.observerLabNotes ??= {began: null, view: null};
  Object.assign(lab, {hand, note, title, next, minutes, words});
  const say = value => window.observerLabViser.tell(lab.hand, value);
  const write = () => {
    const page = lab.view;
    if (!page || page.closed) return;
    const put = (id, text) => { page.document.getElementById(id).textContent = text; };
    put('title', lab.title);
    put('note', lab.note);
    put('next', lab.next ? `${lab.words.next}: ${lab.next}` : '');
    const gone = Math.floor((performance.now() - lab.began) / 1000);
    put('clock', `${Math.floor(gone / 60)}:${String(gone % 60).padStart(2, '0')} / ${lab.minutes} min`);
  };
  lab.write = write;
  lab.open ??= () => {
    lab.view = window.open('', 'observer-lab-notes', 'width=720,height=520');
    if (!lab.view) return;
    lab.began ??= performance.now();
    const page = lab.view.document;
    page.title = lab.words.notes;
    page.body.style.cssText = 'font:22px/1.5 system-ui,sans-serif;margin:1.5rem;max-width:44rem';
    page.body.replaceChildren(...[['h1', 'title'], ['p', 'note'], ['p', 'next'], ['p', 'clock']].map(([tag, id]) =>
      Object.assign(page.createElement(tag), {id})));
    page.onkeydown = event => {
      const turn = {ArrowRight: 1, PageDown: 1, ' ': 1, ArrowLeft: -1, PageUp: -1}[event.key];
      if (turn) { event.preventDefault(); say(`turn:${turn}`); }
    };
    lab.timer ??= setInterval(() => lab.write(), 500);
    lab.write();
  };
  if (!lab.listens) {
    lab.listens = true;
    document.addEventListener('click', event => { if (event.target?.closest?.('.ol-notes')) window.observerLabNotes.open(); });
  }
  write();
}
