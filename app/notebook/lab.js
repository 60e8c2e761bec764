// Shows a lesson in a frame. The kernel says where it is: the address holds a word that must not be stored with the notebook.
const render = ({model, el}) => {
  const frame = document.createElement('iframe'), note = document.createElement('p');
  frame.allow = 'fullscreen; clipboard-write';
  frame.style.border = '0';
  const size = () => {
    frame.title = model.get('title');
    frame.style.width = model.get('width');
    frame.style.height = `${model.get('height')}px`;
  };
  const hear = told => {
    if (told.address && frame.src !== told.address) frame.src = told.address;
    note.textContent = told.problem ?? '';
    note.hidden = !told.problem;
    frame.hidden = !!told.problem;
  };
  size();
  note.hidden = true;
  el.append(frame, note);
  model.on('msg:custom', hear);
  for (const name of ['title', 'width', 'height']) model.on(`change:${name}`, size);
  model.send({origin: location.origin});
  return () => { model.off('msg:custom', hear); };
};
export default {render};
