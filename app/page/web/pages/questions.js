// Shows those questions that hold every word that is typed; all of them while nothing is.
() => {
  const field = document.querySelector('.ol-words'), all = [...document.querySelectorAll('[data-words]')];
  field.addEventListener('input', () => {
    const typed = field.value.toLowerCase().split(/\s+/).filter(Boolean);
    for (const each of all) each.hidden = !typed.every(word => `${each.dataset.words} ${each.innerText.toLowerCase()}`.includes(word));
  });
}
