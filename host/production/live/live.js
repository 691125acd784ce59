'use strict';
// Shows what /stream and /part send; host/production/live_page.h says what that is. Asks for nothing else.
(() => {
  const $ = (id) => document.getElementById(id);
  const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const number = (value, digits) => {
    if (value === undefined) return '–';
    const digits_ = Number(value).toFixed(digits);
    return Number(digits_) === 0 ? digits_.replace('-', '') : digits_;
  };
  const text = (element, value) => { if (element.textContent !== value) element.textContent = value; };

  // Blue, white, red over -1 .. 1; grey where there is no value.
  const colour = (t) => {
    if (Number.isNaN(t)) return [128, 128, 128];
    const s = Math.max(-1, Math.min(1, t));
    const end = s < 0 ? [33, 102, 172] : [178, 24, 43];
    return end.map((c) => 255 + (c - 255) * Math.abs(s));
  };
  let reach = 0.5; // mm, of the colours; of depth images it follows their differences

  // A message: two lengths, JSON, floats.
  const parse = (bytes, offset, json, floats) => ({
    head: JSON.parse(new TextDecoder().decode(bytes.subarray(offset + 8, offset + 8 + json))),
    values: new Float32Array(bytes.slice(offset + 8 + json, offset + 8 + json + floats).buffer),
  });
  const lengths = (bytes, offset) => {
    const view = new DataView(bytes.buffer, bytes.byteOffset + offset, 8);
    return [view.getUint32(0, true), view.getUint32(4, true)];
  };

  const drawProfile = (columns, values) => {
    const canvas = $('profile');
    const g = canvas.getContext('2d');
    const y = values.subarray(0, columns);
    const height = values.subarray(columns, 2 * columns);
    const difference = values.subarray(2 * columns, 3 * columns);
    const seen = [...height].filter((v) => !Number.isNaN(v));
    g.clearRect(0, 0, canvas.width, canvas.height);
    if (seen.length === 0) { text($('span'), 'no line seen'); return; }
    const places = [...y].filter((v) => !Number.isNaN(v));
    const left = Math.min(...places), right = Math.max(...places);
    const low = Math.min(0, ...seen) - 1, high = Math.max(...seen) + 1;
    const px = (v) => 8 + (canvas.width - 16) * (v - left) / Math.max(1, right - left);
    const py = (v) => canvas.height - 8 - (canvas.height - 16) * (v - low) / (high - low);
    const curve = (values_, factor, name) => {
      g.strokeStyle = style(name);
      g.lineWidth = 2;
      g.beginPath();
      let down = false;
      for (let i = 0; i < columns; ++i) {
        if (Number.isNaN(values_[i])) { down = false; continue; }
        const at = [px(y[i]), py(values_[i] * factor)];
        if (down) g.lineTo(...at); else g.moveTo(...at);
        down = true;
      }
      g.stroke();
    };
    // Lines at round heights, with their numbers
    const step = [0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500].find((s) => (high - low) / s <= 6) || 1000;
    const round = [];
    for (let v = Math.ceil(low / step) * step; v <= high; v += step) round.push(v);
    g.strokeStyle = style('--line');
    for (const v of round) {
      g.lineWidth = Math.abs(v) < step / 2 ? 2 : 1;
      g.beginPath(); g.moveTo(8, py(v)); g.lineTo(canvas.width - 8, py(v)); g.stroke();
    }
    curve(height, 1, '--height');
    curve(difference, 10, '--difference');
    g.font = '15px system-ui, sans-serif';
    for (const v of round) { // over the curves, and never above the edge
      const label = `${number(v, step < 1 ? 1 : 0)} mm`, y = Math.max(py(v) - 4, 15);
      g.fillStyle = style('--card');
      g.fillRect(6, y - 14, g.measureText(label).width + 4, 18);
      g.fillStyle = style('--faint');
      g.fillText(label, 8, y);
    }
    const highest = Math.max(...seen).toFixed(2);
    text($('span'), `  y ${left.toFixed(0)} to ${right.toFixed(0)} mm, height up to ${highest} mm`);
    text($('map-note'), `across, y ${left.toFixed(0)} to ${right.toFixed(0)} mm; the newest profile above`);
  };

  const drawWaterfall = (columns, rows, values) => {
    const canvas = $('waterfall');
    const g = canvas.getContext('2d');
    if (canvas.width !== columns) canvas.width = columns;
    if (rows === 0) return;
    g.drawImage(canvas, 0, rows);
    const image = g.createImageData(columns, rows);
    for (let r = 0; r < rows; ++r) {
      for (let c = 0; c < columns; ++c) {
        const at = 4 * ((rows - 1 - r) * columns + c); // the newest above
        const [red, green, blue] = colour(values[3 * columns + r * columns + c] / reach);
        image.data.set([red, green, blue, 255], at);
      }
    }
    g.putImageData(image, 0, 0);
  };

  // The colours reach to what 98 % of the differences stay below, rounded up to 1, 2 or 5 times a power of ten. They
  // change only where that is more, or less than a third, so that the picture does not flicker.
  const setReach = (values) => {
    const sizes = [...values].filter((v) => !Number.isNaN(v)).map(Math.abs).sort((a, b) => a - b);
    if (sizes.length === 0) return;
    const most = Math.max(0.01, sizes[Math.floor(0.98 * (sizes.length - 1))]);
    if (most <= reach && most > reach / 3) return;
    const power = 10 ** Math.floor(Math.log10(most));
    reach = power * ([1, 2, 5].find((step) => step * power >= most) || 10);
    text($('reach'), `−${Number(reach.toPrecision(1))} to +${Number(reach.toPrecision(1))} mm`);
  };

  const drawMap = (columns, rows, values) => {
    const canvas = $('waterfall');
    if (canvas.width !== columns) canvas.width = columns;
    if (canvas.height !== rows) canvas.height = rows;
    setReach(values);
    const g = canvas.getContext('2d');
    const image = g.createImageData(columns, rows);
    for (let i = 0; i < rows * columns; ++i) image.data.set([...colour(values[i] / reach), 255], 4 * i);
    g.putImageData(image, 0, 0);
  };

  const solid = (() => {
    const canvas = $('solid');
    if (typeof THREE === 'undefined') {
      text($('solid-note'), 'three.js is not installed on the machine of the line (Debian: libjs-three): no 3-D view.');
      return null;
    }
    let renderer;
    try {
      renderer = new THREE.WebGLRenderer({canvas, antialias: true, alpha: true, preserveDrawingBuffer: true});
    } catch (error) {
      text($('solid-note'), 'This browser has no WebGL: no 3-D view.');
      return null;
    }
    renderer.setSize(canvas.width, canvas.height, false);
    const scene = new THREE.Scene();
    const camera = new THREE.PerspectiveCamera(35, canvas.width / canvas.height, 1, 5000);
    camera.up.set(0, 0, 1);
    scene.add(new THREE.AmbientLight(0xffffff, 0.55));
    const sun = new THREE.DirectionalLight(0xffffff, 0.6);
    sun.position.set(-1, -0.6, 1.5);
    scene.add(sun);
    let mesh = null;
    let turn = -0.9, tilt = 0.75, away = 100;
    const draw = () => {
      const beside = away * Math.cos(tilt);
      camera.position.set(beside * Math.cos(turn), beside * Math.sin(turn), away * Math.sin(tilt));
      camera.lookAt(0, 0, 0);
      renderer.render(scene, camera);
    };
    let from = null;
    canvas.addEventListener('pointerdown', (event) => {
      from = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener('pointerup', () => { from = null; });
    canvas.addEventListener('pointermove', (event) => {
      if (!from) return;
      turn -= (event.clientX - from[0]) * 0.01;
      tilt = Math.max(-0.2, Math.min(1.5, tilt + (event.clientY - from[1]) * 0.01));
      from = [event.clientX, event.clientY];
      draw();
    });
    return (head, values) => {
      const {rows, columns} = head;
      const pitch = head.pitch_mm;
      const cells = rows * columns;
      let middle = 0, count = 0;
      for (let i = 0; i < cells; ++i) if (!Number.isNaN(values[i])) { middle += values[i]; ++count; }
      middle /= Math.max(1, count);
      const positions = new Float32Array(3 * cells), colours = new Float32Array(3 * cells), index = [];
      for (let r = 0; r < rows; ++r) {
        for (let c = 0; c < columns; ++c) {
          const i = r * columns + c;
          const up = Number.isNaN(values[i]) ? 0 : values[i] - middle;
          positions.set([(r - rows / 2) * pitch, (c - columns / 2) * pitch, up], 3 * i);
          const zero = Number.isNaN(head.zero) ? 0 : head.zero;
          colours.set(colour((values[cells + i] - zero) / reach).map((v) => v / 255), 3 * i);
          if (r + 1 < rows && c + 1 < columns) {
            const corners = [i, i + 1, i + columns, i + columns + 1];
            if (corners.every((k) => !Number.isNaN(values[k]))) {
              index.push(i, i + columns, i + 1, i + 1, i + columns, i + columns + 1);
            }
          }
        }
      }
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
      geometry.setAttribute('color', new THREE.BufferAttribute(colours, 3));
      geometry.setIndex(index);
      geometry.computeVertexNormals();
      if (mesh) { scene.remove(mesh); mesh.geometry.dispose(); mesh.material.dispose(); }
      const material = new THREE.MeshLambertMaterial({vertexColors: THREE.VertexColors, side: THREE.DoubleSide});
      mesh = new THREE.Mesh(geometry, material);
      scene.add(mesh);
      away = 1.9 * Math.max(rows, columns) * pitch;
      canvas.dataset.triangles = String(index.length / 3);
      draw();
    };
  })();

  let shown = 0, solidShown = 0; // numbers of the parts in the table and in the 3-D view
  let drawing = false, nextSolid = 0;
  const fetchPart = async () => {
    const bytes = new Uint8Array(await (await fetch('part', {credentials: 'same-origin'})).arrayBuffer());
    const [json, floats] = lengths(bytes, 0);
    const {head, values} = parse(bytes, 0, json, floats);
    if (!head.part || !solid) return;
    text($('solid-note'), `Part ${head.part}, ${head.verdict}: height, coloured by the difference. Drag to turn.`);
    // The colours are about the mean difference of the regions, so that a part on a bare plane shows its defects too.
    const means = head.regions.map((region) => region.mean_mm);
    head.zero = means.reduce((sum, v) => sum + v, 0) / Math.max(1, means.length);
    solid(head, values);
  };

  let imageShown = 0, asking = false;
  const fetchCamera = async () => {
    const bytes = new Uint8Array(await (await fetch('camera', {credentials: 'same-origin'})).arrayBuffer());
    const [json] = lengths(bytes, 0);
    const head = JSON.parse(new TextDecoder().decode(bytes.subarray(8, 8 + json)));
    if (!head.rows) return;
    const canvas = $('camera');
    if (canvas.width !== head.columns) canvas.width = head.columns;
    if (canvas.height !== head.rows) canvas.height = head.rows;
    const g = canvas.getContext('2d');
    const image = g.createImageData(head.columns, head.rows);
    const line = new Float32Array(bytes.slice(8 + json, 8 + json + 4 * head.line).buffer);
    const pixels = bytes.subarray(8 + json + 4 * head.line);
    let saturated = 0;
    for (let i = 0; i < head.rows * head.columns; ++i) {
      const grey = pixels[i];
      // Saturated pixels are red.
      image.data.set(grey === 255 ? [255, 60, 60, 255] : [grey, grey, grey, 255], 4 * i);
      saturated += grey === 255;
    }
    g.putImageData(image, 0, 0);
    g.fillStyle = style('--found');
    let found = 0;
    for (let c = 0; c < head.line; ++c) {
      if (Number.isNaN(line[c])) continue;
      g.fillRect(c, Math.round(line[c] / head.every), 1, 1);
      ++found;
    }
    const percent = (share) => `${(100 * share).toFixed(1)} %`;
    text($('exposure'), head.advice);
    $('exposure').className = head.good ? 'good' : 'bad';
    text($('shares'), head.line
      ? `frame ${head.frame}; line in ${percent(1 - head.dark)} of the columns, ` +
        `${percent(head.saturated)} of it saturated`
      : `frame ${head.frame}; ${percent(head.saturated)} of the pixels saturated, ${percent(head.dark)} dark`);
    canvas.dataset.found = String(found);
    canvas.dataset.saturated = String(saturated);
    $('camera-now').hidden = false;
  };

  // What the moments say of a part, as the board's circuit judges them; nothing where no verdict runs.
  const byMoments = (part) => {
    const found = part.moments;
    if (!found) return '';
    return found.frames === 0 ? '–' : found.defect ? 'defect' : 'good';
  };
  const row = (cells, kind) => {
    const line = document.createElement('tr');
    cells.forEach((value, i) => {
      if (value === '') return;
      const cell = document.createElement('td');
      cell.textContent = value;
      if (i === 1 && kind) cell.className = kind.split(' ')[0];
      line.append(cell);
    });
    return line;
  };

  const LABELS = {
    frames_per_second: 'frames a second', profiles: 'profiles', depth_images: 'depth images',
    depth_images_per_second: 'depth images a second', incomplete: 'incomplete images', parts: 'parts',
    parts_good: 'good', parts_bad: 'bad',
    parts_inconclusive: 'inconclusive', specks: 'too short for a part',
    verdict_parts_with_defect: 'with a defect by moments', verdict_more: 'by moments alone',
    verdict_less: 'by heights alone', board_frames: 'frames judged by the board',
    board_disagrees: 'judged otherwise by the model',
    result_delay_p50_ms: 'result after last frame, median (ms)',
    result_delay_p99_ms: 'result after last frame, 99 % (ms)', delay_p50_us: 'packet to profile, median (µs)',
    delay_p99_us: 'packet to profile, 99 % (µs)', lost_board: 'lost on the board', lost_ring: 'lost in the ring',
    lost_network: 'lost in the network', missing: 'missing frames', bad: 'bad packets',
    live_dropped: 'pictures dropped for slow browsers',
  };

  // The names of figures as statistics.json has them, for people.
  const nameOf = (key) => key.replace(/^across_mm$/, 'shift across, mm').replace(/^residual_mm$/, 'off the outline, mm')
    .replace(/ (missing|[a-z]+_mm)$/, ': $1').replace(/_mm$/, ', mm').replace(/_deg$/, ', °');
  const show = (head, values) => {
    text($('title'), head.title);
    document.title = head.title;
    const depth = head.kind === 'depth';
    $('profile-now').hidden = depth;
    text($('map-title'), depth ? 'Difference now' : 'Difference, running');
    if (depth) {
      drawMap(head.columns, head.rows, values);
    } else {
      drawProfile(head.columns, values);
      drawWaterfall(head.columns, head.rows, values);
    }
    // Without a tolerance no parts are classified.
    for (const section of document.querySelectorAll('.parts')) section.hidden = !('parts' in head.figures);
    text($('doubt'), head.figures.doubt || '');
    $('doubt').hidden = !head.figures.doubt;
    const known = Object.entries(LABELS).filter(([key]) => key in head.figures);
    $('figures').replaceChildren(...known.flatMap(([key, label]) => {
      const dt = document.createElement('dt'), dd = document.createElement('dd');
      dt.textContent = label;
      const value = head.figures[key];
      dd.textContent = Number.isInteger(value) ? String(value) : value.toFixed(key.endsWith('_per_second') ? 0 : 2);
      dd.dataset.key = key;
      return [dt, dd];
    }));
    const figures = head.figures;
    const rate = figures.frames_per_second ?? figures.depth_images_per_second;
    const lost = ['lost_board', 'lost_ring', 'lost_network'].reduce((sum, key) => sum + (figures[key] || 0), 0);
    text($('rate'), rate === undefined ? '' :
      `${rate.toFixed(0)} ${depth ? 'depth images' : 'frames'}/s, ${lost ? `${lost} lost` : 'nothing lost'}`);
    if (head.camera !== imageShown && !asking) {
      imageShown = head.camera;
      asking = true;
      fetchCamera().catch(() => {}).finally(() => { asking = false; });
    }
    const newest = head.parts[0];
    if (newest && newest.part !== shown) {
      shown = newest.part;
      text($('verdict'), newest.verdict);
      $('verdict').className = newest.verdict;
      text($('reason'), `part ${newest.part}${newest.reason ? `: ${newest.reason}` : ''}`);
      document.querySelector('#parts .moments').hidden = !newest.moments;
      $('parts').tBodies[0].replaceChildren(...head.parts.map((part) => {
        const placed = part.placement || {};
        const worst = part.defects[0];
        return row([String(part.part), part.verdict, byMoments(part), String(part.defects.length),
          worst ? (worst.depth_mm > 0 ? '+' : '') + number(worst.depth_mm, 2) : '–', number(placed.length_mm, 2),
          number(placed.across_mm, 2), number(placed.turn_deg, 2)], part.verdict);
      }));
      $('statistics').tBodies[0].replaceChildren(...Object.entries(head.statistics).map(([name, f]) =>
        row([nameOf(name), number(f.mean, 4), f.parts > 1 ? number(f.spread, 4) : '–',
          f.rise_error_in_1000_parts === null || Math.abs(f.rise_in_1000_parts) <= 3 * f.rise_error_in_1000_parts
            ? '–' : number(f.rise_in_1000_parts, 4)])));
    }
    // The 3-D view takes a browser much longer than the tables: two parts a second are enough for the eye.
    if (newest && newest.part !== solidShown && !drawing && performance.now() >= nextSolid) {
      solidShown = newest.part;
      drawing = true;
      fetchPart().catch(() => {}).finally(() => {
        drawing = false;
        nextSolid = performance.now() + 500;
      });
    }
  };

  // Reads the stream; connects again when it ends.
  const watch = async () => {
    const response = await fetch('stream', {credentials: 'same-origin'});
    if (!response.ok) throw new Error(await response.text());
    shown = solidShown = imageShown = 0;
    text($('connection'), 'connected');
    document.body.classList.remove('stale');
    const reader = response.body.getReader();
    let bytes = new Uint8Array(0);
    for (;;) {
      const {done, value} = await reader.read();
      if (done) return;
      const joined = new Uint8Array(bytes.length + value.length);
      joined.set(bytes);
      joined.set(value, bytes.length);
      bytes = joined;
      let offset = 0;
      for (; bytes.length - offset >= 8;) {
        const [json, floats] = lengths(bytes, offset);
        if (bytes.length - offset < 8 + json + floats) break;
        if (json > 0) {
          const {head, values} = parse(bytes, offset, json, floats);
          show(head, values);
        }
        offset += 8 + json + floats;
      }
      bytes = bytes.slice(offset);
    }
  };
  (async () => {
    for (;;) {
      try { await watch(); } catch (error) { /* told below */ }
      text($('connection'), 'not connected: what is below is old; trying again');
      document.body.classList.add('stale');
      await new Promise((resolve) => setTimeout(resolve, 1000));
    }
  })();
})();
