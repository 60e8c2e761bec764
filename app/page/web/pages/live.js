// Says to a widget which picture of the running plant the page has drawn, at once, and every 400 ms that it is still there.
({widget}) => {
  const EVERY = 400, BEATS = 1000;  // ms; what a count is below
  let count = 0, drawn = 0;
  const tell = () => window.observerLabViser.tell(widget, drawn * BEATS + ++count % BEATS);
  const look = () => {
    if (window.observerLabLive?.widget !== widget) return;
    const number = Number(document.querySelector('.ol-running')?.dataset.picture ?? 0);
    if (number !== drawn) {
      drawn = number;
      tell();
    }
    requestAnimationFrame(look);
  };
  clearInterval(window.observerLabLive?.beat);
  window.observerLabLive = {widget, beat: setInterval(tell, EVERY)};
  requestAnimationFrame(look);
}
