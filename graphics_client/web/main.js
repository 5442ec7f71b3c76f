// The page: what it watches is in haptics.json beside it, or in the address (?nats=ws://HOST:PORT&session=NAME).
import {Picture} from './picture.js';
import {WatchedSession} from './watched_session.js';
import {hex} from './scene.js';

const element = (id) => document.getElementById(id);
const length = (metres) => (metres >= 1 ? `${metres} m` : metres >= 0.01 ? `${Math.round(100 * metres)} cm` : `${Math.round(1e6 * metres) / 1000} mm`);
const newton = (vector) => Math.hypot(vector?.x || 0, vector?.y || 0, vector?.z || 0);

/** User and password of the file are for its own server: a link may lead to another one. */
async function options() {
  const file = await fetch('haptics.json').then((answer) => (answer.ok ? answer.json() : {})).catch(() => ({}));
  const link = Object.fromEntries(new URLSearchParams(location.search));
  const {user, pass, ...rest} = file;
  return (link.nats ?? file.nats) === file.nats ? {...file, ...link} : {...rest, ...link};
}

function show(chosen) {
  const picture = new Picture(element('picture'));
  const session = new WatchedSession(chosen, {
    scene(scene, welcome) {
      picture.limit_N = welcome.max_force_N || 0;
      picture.showScene(scene);
      element('grid').textContent = `floor, lines ${length(picture.spacing_m)} apart`;
      element('scene').textContent = `revision ${scene.revision} · ${hex(scene.root).slice(0, 12)} · equal`;
      element('device').textContent = welcome.device;
      Object.assign(state, {epoch: scene.epoch, revision: scene.revision, root: hex(scene.root)});
    },
    asset(name, bytes) {
      picture.addAsset(name, bytes);
      element('grid').textContent = `floor, lines ${length(picture.spacing_m)} apart`;
    },
    drop: (name) => picture.dropAsset(name),
    telemetry(sample) {
      picture.showSample(sample);
      state.tick = Number(sample.tick);
      element('force').textContent = `${newton(sample.force?.written).toFixed(2)} N`;
    },
    state(word, sentence) {
      state.word = word;
      element('state').className = word;
      element('state').textContent = sentence;
    },
  });
  // What is shown, for who tests the page.
  const state = window.haptics = {
    word: null, epoch: null, revision: 0, root: null, tick: 0,
    get fps() { return picture.fps(); },
    get saw() { return session.saw; },
    get assets() { return picture.assets.size; },
    /** As it is drawn, in metres. */
    get ihip() { return picture.hands[0].ihip.getPosition(); },
    get hip() { return picture.hands[0].hip.getPosition(); },
    get objects() {
      return [...picture.objects.values()].map(({state: {id, name}, surface, actor, heights, pose, dents}) =>
        ({id: String(id), name, isDrawn: Boolean(actor) && Boolean(heights) === Boolean(surface), heights, pose, dents: dents.length}));
    },
  };
  picture.names = element('names');
  element('fit').addEventListener('click', () => {
    picture.isFitted = false;
    picture.fit();
  });
  element('named').addEventListener('change', ({target}) => { picture.names.hidden = !target.checked; });
  if (window.matchMedia('(max-width: 40rem)').matches) element('legend').open = false;
  session.run();
}

options().then((chosen) => {
  if (chosen.nats && chosen.session) return show(chosen);
  element('state').textContent = 'haptics.json, or the address, has to name nats and session';
});
