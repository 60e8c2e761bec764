// Runs before viser's page and brings it back after any outage: viser itself tries every second, throws a pending attempt away, and
// only while the page has the focus. A server that is silent is asked; one that does not answer is waited for, and its page told so.
// A page whose place the server has taken back, since nobody touched it, waits for a hand.
({version, reloads, rest}) => {
  const TICK = 1000, QUIET = 3, DEAD = 5;  // ms; ticks of silence after which the server is asked, and until it must have answered
  const FIRST = 300, LONGEST = 8000, PATIENCE = 6000, OPENING = 12000, CAMERA = 60, ATTEMPTS = 3, BETWEEN_RELOADS = 30000;  // ms, and attempts
  const viser = window.observerLabViser, ask = {type: 'LocalStorageGetItemResponseMessage', value: null, error: null};
  const line = window.observerLabLine = {lost: true, onLost: () => {}, onAnswer: () => {}, onRest: () => {}, onBack: () => {}, onReturn: () => {}, onReload: () => {}, take: () => {}, missed: () => {}, unanswered: () => null};
  let quiet = 0, asked = 0, opened = null, woken = null, comes = false;

  const beat = () => {
    asked = 1;
    viser.send({...ask, request_uuid: `beat:${line.unanswered() ?? ''}`});
  };
  setInterval(() => {
    if (line.lost) return;
    quiet += 1;
    if (asked > DEAD) comeBack();
    else if (asked) asked += 1;
    else if (quiet >= QUIET || line.unanswered() !== null) beat();
  }, TICK);

  const sleep = ms => new Promise(done => {
    woken = done;
    setTimeout(done, ms);
  });
  for (const [target, kind] of [[window, 'online'], [window, 'focus'], [document, 'visibilitychange']]) {
    target.addEventListener(kind, () => woken?.());
  }
  const health = async patience => {
    try {
      const answer = await fetch('health', {cache: 'no-store', headers: {'Came-By': location.origin}, signal: AbortSignal.timeout(patience)});
      return {...answer.ok ? await answer.json() : {}, status: answer.status};
    } catch (error) { return null; }
  };
  const reload = () => {
    const now = Date.now();
    try {
      if (now - Number(sessionStorage.getItem(reloads) ?? 0) < BETWEEN_RELOADS) return;
      sessionStorage.setItem(reloads, String(now));
      line.onReload();
    } catch (error) { console.warn('not kept', error); }
    location.reload();
  };
  const connects = () => new Promise(done => {
    opened = done;
    setTimeout(done, OPENING, false);
    viser.reconnect();
  });
  const comeBack = async () => {
    if (comes) return;
    comes = line.lost = true;
    line.onLost();
    let pause = FIRST, patience = PATIENCE, failed = 0;
    while (line.lost) {
      await sleep(pause * (0.75 + Math.random() / 2));
      pause = Math.min(2 * pause, LONGEST);
      const found = await health(patience);
      patience = Math.min(1.5 * patience, 30000);  // where the way is long
      if (found === null || !line.lost) continue;
      line.onAnswer(found.status);
      if (![200, 404].includes(found.status)) continue;  // some proxies know no such path
      if (found.version && found.version !== version) reload();  // the page is one of the server before
      if (await connects()) break;
      failed += 1;
      if (failed >= ATTEMPTS && found.version) reload();
    }
    comes = false;
  };
  const waitForHand = () => {
    if (comes) return;
    comes = line.lost = true;
    line.onRest();
    const ways = [...['pointerdown', 'keydown', 'wheel', 'touchstart'].map(kind => [window, kind]), [document, 'visibilitychange']];
    const wake = () => {
      if (document.hidden) return;
      ways.forEach(([target, kind]) => target.removeEventListener(kind, wake, {capture: true}));
      comes = false;
      comeBack();
    };
    ways.forEach(([target, kind]) => target.addEventListener(kind, wake, {capture: true, passive: true}));
  };
  viser.onConnection = (type, {versionMismatch, closeReason} = {}) => {  // whether viser's page may hear of it
    if (type === 'connected') {
      line.lost = false;
      quiet = asked = 0;
      setTimeout(viser.tellCamera, CAMERA);  // after which the server opens a tab; viser's page says it where it has heard of the end
      line.onBack();
      line.onReturn();
    }
    opened?.(type === 'connected');
    opened = null;
    if (type === 'closed') (closeReason === rest ? waitForHand : comeBack)();
    if (versionMismatch) reload();
    return type !== 'closed';
  };
  viser.onBatch = messages => {
    if (line.lost) return false;  // a connection that was given up speaks again: what it answers is done on the next one
    quiet = asked = 0;
    line.take(messages);
    return true;
  };
}
