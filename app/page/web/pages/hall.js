// Shows the results of a vote, or the time to discuss, in large print over the stage; nothing where there is nothing to show.
({html}) => {
  const viser = window.observerLabViser, lab = window.observerLabHall ??= {};
  lab.board ??= document.body.appendChild(Object.assign(document.createElement('section'), {className: 'ol-hall'}));
  lab.board.innerHTML = html;
  lab.board.hidden = !html;
  const place = () => {
    const box = viser.canvas()?.getBoundingClientRect();
    if (box) Object.assign(lab.board.style, {left: `${box.left}px`, top: `${box.top}px`, width: `${box.width}px`, height: `${box.height}px`});
  };
  place();
  if (lab.listens) return;
  lab.listens = true;
  new ResizeObserver(place).observe(viser.canvas() ?? document.body);
  addEventListener('resize', place);
}
