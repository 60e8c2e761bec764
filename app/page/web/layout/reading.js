// Says beside the pointer what the curves of a chart are where it points: the time or frequency, and each curve's value.
() => {
  if (window.observerLabReading) return;
  const viser = window.observerLabViser, note = window.observerLabReading = document.createElement('div');
  note.className = 'ol-reading';
  note.hidden = true;
  document.body.append(note);
  const plain = value => Math.abs(value) >= 1e-3 && Math.abs(value) < 1e5 ? String(Number(value.toPrecision(3))) : value.toExponential(2);
  const written = value => value === 0 ? '0' : plain(value).replace(/-/g, '−');
  const row = (words, colour) => {
    const line = document.createElement('div'), mark = document.createElement('b');
    mark.style.color = colour;
    mark.textContent = colour ? '▬ ' : '';
    line.append(mark, words);
    return line;
  };
  document.addEventListener('pointermove', event => {
    const over = event.target?.closest?.(viser.parts.plot), found = over && viser.charts().find(each => each.over === over);
    const chart = found && getComputedStyle(found.ctx.canvas).filter === 'none' ? found : null;  // none under a veil
    note.hidden = !chart;
    if (!chart) return;
    const at = chart.posToIdx(event.clientX - over.getBoundingClientRect().left);
    const told = chart.series.slice(1).map((series, k) => ({series, value: chart.data[k + 1][at]}));
    const [name, unit] = chart.series[0].label === 'f' ? ['f', 'Hz'] : ['t', 's'];
    note.replaceChildren(row(`${name} = ${written(chart.data[0][at])} ${unit}`, ''), ...told.filter(({value}) => value != null && !Number.isNaN(value))
      .map(({series, value}) => row(`${series.label} ${written(value)}`, viser.strokeOf(chart, series) ?? '')));
    const room = note.getBoundingClientRect();
    note.style.left = `${Math.max(4, Math.min(event.clientX + 14, innerWidth - room.width - 4))}px`;
    note.style.top = `${Math.max(4, event.clientY - room.height - 10)}px`;
  });
}
