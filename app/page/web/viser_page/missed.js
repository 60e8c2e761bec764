// What a hand did has come to the server when its widget had gone, with the number of the last press: it is done on the page that stands now.
({widget, press}) => {
  window.observerLabLine?.missed(widget, press);
}
