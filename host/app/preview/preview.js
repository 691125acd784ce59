'use strict';
// Asks for the newest image and its figures again and again, the next ones when these have come.

const byId = (id) => document.getElementById(id);
const pause = (ms) => new Promise((done) => setTimeout(done, ms));

async function show(number) {
  const answer = await fetch('figures', {cache: 'no-store'});
  if (!answer.ok) throw new Error('the server refuses: ' + answer.status);
  const figures = await answer.json();
  byId('camera').textContent = figures.camera;
  delete figures.camera;
  byId('figures').replaceChildren(...Object.entries(figures).flatMap(([name, value]) => {
    const [term, text] = [document.createElement('dt'), document.createElement('dd')];
    term.textContent = name;
    text.textContent = value;
    return [term, text];
  }));
  const image = new Image();
  image.src = 'image.png?' + number;
  await image.decode();
  byId('image').src = image.src;
}

(async () => {
  for (let number = 0; ; ++number) {
    try {
      await show(number);
      byId('connection').textContent = 'live';
      await pause(100);
    } catch (error) {
      byId('connection').textContent = 'no connection; trying again';
      await pause(1000);
    }
  }
})();
