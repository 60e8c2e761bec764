// Writes the labels of the stage in an ink on a ground of the theme; viser knows black on white alone.
({ink, ground}) => {
  const viser = window.observerLabViser, lab = window.observerLabLabels ??= {ink: {value: []}, ground: {value: []}};
  const parts = colour => [1, 3, 5].map(i => parseInt(colour.slice(i, i + 2), 16) / 255);
  lab.ink.value = parts(ink);
  lab.ground.value = parts(ground);
  viser.colourLabels(lab.ink, lab.ground);
  viser.redraw();
}
