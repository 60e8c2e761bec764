// Runs before viser's page: shows our name until a lesson stands, and says so for as long as the server does not answer.
({words, language, kept}) => {
  const root = document.documentElement, cover = document.createElement('div'), note = document.createElement('div');
  const known = code => words[code] ?? words[language];
  const remembered = () => { try { return sessionStorage.getItem(kept); } catch (error) { return null; } };
  root.lang = known(remembered()) === words[remembered()] ? remembered() : language;
  cover.className = 'ol-cover';
  note.className = 'ol-lost';
  note.hidden = true;
  note.setAttribute('role', 'alert');
  let stranger = false, asked = false;
  const speak = () => {
    const said = known(root.lang), name = document.createElement('b'), loading = document.createElement('span');
    name.textContent = said.name;
    loading.textContent = said.loading;
    cover.replaceChildren(name, loading);
    note.textContent = stranger ? said.stranger.replaceAll('{name}', location.hostname) : said.lost;
  };
  const ask = async () => {  // a proxy that rewrites Host lets the page through and not its connection
    try {
      stranger = (await fetch('health', {headers: {'Came-By': location.origin}})).status === 421;
    } catch (error) { stranger = false; }
    if (stranger) { speak(); note.hidden = false; }
  };
  speak();
  root.append(cover, note);
  let old = null;
  const look = () => {
    const question = document.querySelector('.ol-question,.ol-scene');
    if (question && question !== old) { cover.hidden = true; watch.disconnect(); }
  };
  const watch = new MutationObserver(look);
  window.observerLabViser.onConnection = type => {
    if (type === 'closed') {
      if (!asked) { asked = true; ask(); }
      speak();
      note.hidden = false;
    } else if (type === 'connected') {
      note.hidden = true;
      stranger = asked = false;
      old = document.querySelector('.ol-question,.ol-scene');  // of the connection before: viser keeps it until the new one speaks
      cover.hidden = false;
      watch.observe(root, {childList: true, subtree: true});
    }
  };
}
