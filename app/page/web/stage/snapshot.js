// A press on "stage as PNG" keeps what the stage shows, drawn anew with all its pixels on the page's own ground.
() => {
  if (window.observerLabSnapshot) return;
  window.observerLabSnapshot = true;
  const viser = window.observerLabViser, BANDS = ['--ol-sky', '--ol-mist', '--ol-ground'], AT = [0, .45, 1];
  const keep = (canvas, name) => {
    const picture = document.createElement('canvas'), pen = picture.getContext('2d'), style = getComputedStyle(document.documentElement);
    [picture.width, picture.height] = [canvas.width, canvas.height];
    const ground = pen.createLinearGradient(0, 0, 0, picture.height);
    BANDS.forEach((band, k) => ground.addColorStop(AT[k], style.getPropertyValue(band).trim()));
    pen.fillStyle = ground;
    pen.fillRect(0, 0, picture.width, picture.height);
    pen.drawImage(canvas, 0, 0);
    const link = document.createElement('a');
    link.download = name;
    link.href = picture.toDataURL('image/png');
    link.click();
  };
  document.addEventListener('click', event => {
    const button = event.target?.closest?.('button.ol-snapshot');
    if (!button || button.disabled) return;
    const before = viser.resolution();
    viser.setResolution(Math.max(devicePixelRatio, 2));
    viser.afterFrame(() => queueMicrotask(() => {  // the frame is whole and still there: the browser takes it away when this turn has ended
      keep(viser.canvas(), button.dataset.name);
      setTimeout(() => { viser.setResolution(before); viser.drawFrame(); });
    }));
    viser.drawFrame();
  });
}
