// Each answer of the server is drawn in one frame; where frames come slowly, with fewer pixels while things move.
() => {
  const viser = window.observerLabViser;
  if (!viser.isDrawn() || viser.scene().userData.watched) return;
  viser.scene().userData.watched = true;
  const SLOW = 34, COARSE = 0.6, REST = 450, TOGETHER = 24, COUNT = 9, opened = performance.now(), gaps = [];
  const sharp = devicePixelRatio * (window.observerLabNoCard ? 1.5 : 1);
  let last = 0, slow = !!window.observerLabNoCard, timer = 0, due = 0;
  const draw = dpr => { if (viser.resolution() !== dpr) viser.setResolution(dpr); };
  const frame = () => { clearTimeout(due); due = 0; viser.drawFrame(); };
  viser.afterFrames(() => {
    const now = performance.now(), gap = now - last;
    last = now;
    if (slow || gap > 250 || now - opened < 2500) return;
    gaps.push(gap);
    if (gaps.length > COUNT) gaps.shift();
    slow = gaps.length === COUNT && [...gaps].sort((a, b) => a - b)[COUNT >> 1] > SLOW;
  });
  viser.onSize(() => viser.drawNow());  // a canvas that gets another size after the browser's frame began would be shown empty
  viser.onRedraw(ask => {
    viser.hideEmptyBackground();
    viser.takeUp(true);
    if (!slow) { ask(); return; }
    draw(COARSE * devicePixelRatio);
    if (window.event?.type?.startsWith('pointer')) due ||= setTimeout(frame, TOGETHER); else frame();
    clearTimeout(timer);
    timer = setTimeout(() => { draw(sharp); viser.drawFrame(); }, REST);
  });
}
