"use strict";
// One rating session in a browser.
const study = "STUDY";

// What the page says, in the language that it was made in.
function word(name, values) {
  return study.words[name].replace(/\{(\w+)\}/g, (_, field) => values[field]);
}

// Numbers from 0 to 1 that follow from a text: FNV-1a, then xorshift (Marsaglia, 2003).
function chance(text) {
  let state = 2166136261;
  for (const letter of text) state = Math.imul(state ^ letter.charCodeAt(0), 16777619);
  state = state || 1;
  const next = () => {
    state ^= state << 13;
    state ^= state >>> 17;
    state ^= state << 5;
    return (state >>> 0) / 4294967296;
  };
  // The first ones of two texts that are alike are alike.
  for (let k = 0; k < 20; k++) next();
  return next;
}

function drawn(names, next) {
  const left = [...names];
  return names.map(() => left.splice(Math.floor(next() * left.length), 1)[0]);
}

// Keeps pictures of one face from following one another, where that can be.
function apart(names) {
  const face = new Map(names.map((name) => [name, study.faces.findIndex((one) => one.includes(name))]));
  const left = [...names];
  const order = [];
  const count = new Map();
  for (const one of face.values()) count.set(one, (count.get(one) || 0) + 1);
  while (left.length) {
    const last = face.get(order[order.length - 1]);
    // A face with more than half of what is left comes now, or couldn't be kept apart later.
    const due = [...count].find(([one, many]) => 2 * many > left.length && one !== last);
    const next = left.find((name) => (due ? face.get(name) === due[0] : face.get(name) !== last)) || left[0];
    left.splice(left.indexOf(next), 1);
    count.set(face.get(next), count.get(face.get(next)) - 1);
    order.push(next);
  }
  return order;
}

// Whether pictures that are the same lie more than three places apart.
function untwinned(order) {
  return study.twins.every((twins) => {
    const places = twins.map((name) => order.indexOf(name)).filter((place) => place >= 0).sort((a, b) => a - b);
    return places.every((place, k) => !k || place - places[k - 1] > 3);
  });
}

// How a session begins; all of it follows from study, code and number. Numbers in turn give every face as often, and
// both ways of the keys to each block of faces; without one, chance does.
function fresh(rater, number) {
  const next = chance(study.study + ":" + rater);
  const faces = study.faces.length;
  const each = Math.min(study.conduct.faces_each || faces, faces);
  const divisor = (a, b) => (b ? divisor(b, a % b) : a);
  const blocks = faces / divisor(faces, each) || 1;
  if (!(Number.isInteger(number) && number >= 0)) number = Math.floor(next() * blocks * 2);
  const judged = new Set();
  for (let k = 0; k < each; k++) for (const name of study.faces[(number * each + k) % faces]) judged.add(name);
  const block = (names) => {
    const own = names.filter((name) => !faces || judged.has(name));
    let order = apart(drawn(own, next));
    for (let tries = 0; tries < 100 && !untwinned(order); tries++) order = apart(drawn(own, next));
    return order;
  };
  const keys = study.conduct.swap_keys && Math.floor(number / blocks) % 2 ? "jf" : "fj";
  const order = [...drawn(study.practice, next), ...block(study.ratings), ...block(study.satisfaction)];
  return { rater, order, keys, records: [] };
}

// The answers that stand, oldest first.
function standing(records) {
  const told = [];
  for (const record of records) record.back ? told.pop() : told.push(record);
  return told;
}

function file(session) {
  const { rater, order, keys } = session;
  const head = Object.assign({}, study.header, { rater, keys, order });
  return [head, ...session.records].map((line) => JSON.stringify(line) + "\n").join("");
}

// The browser stores the sessions, by the rater's code. Below, the script needs a browser.
const place = (rater) => "kogao-ratings:" + study.study + ":" + rater;

function stored(rater) {
  try {
    return JSON.parse(localStorage.getItem(place(rater)));
  } catch (problem) {
    return null;
  }
}

// Stores a session; without a session, deletes the stored one.
function store(rater, session) {
  try {
    if (session) localStorage.setItem(place(rater), JSON.stringify(session));
    else localStorage.removeItem(place(rater));
  } catch (problem) {
    // The first page has warned that this browser stores nothing.
  }
}

// What the address says of the session: its number, or the rater's code under one of the names that are usual.
function asked(...names) {
  const said = new URLSearchParams(location.search);
  return names.map((name) => said.get(name)).find((one) => one);
}

if (typeof document !== "undefined") begin();

function begin() {
  const part = (id) => document.getElementById(id);
  const { conduct } = study;
  // Few scales, CSS px a px, so that few conditions differ: a session has the largest that fits when it begins.
  const scales = [1, 3 / 4, 1 / 2, 3 / 8, 1 / 3];
  const fixed = conduct.size !== "fit";
  let session = null;
  // Number of lines in the file that was saved last.
  let saved = 0;
  let scale = null;
  // After how many answers the last pause was.
  let pausedAt = null;
  let shownAt = 0;
  // Time, ms, in which another tab or window was in front, since the picture was painted; from when on one is.
  let away = 0;
  let leftAt = null;
  let ready = false;
  let blocked = ""; // why the picture is not shown
  let touched = false;

  const done = () => standing(session.records).length;

  function say(id, text) {
    part(id).textContent = text;
    part(id).hidden = !text;
  }

  function only(id) {
    for (const main of document.querySelectorAll("main")) main.hidden = main.id !== id;
  }

  function welcome() {
    const pictures = study.ratings.length;
    // Which key says what is known once a session has begun; its buttons tell.
    if (conduct.swap_keys) for (const told of document.querySelectorAll(".two")) told.remove();
    document.body.classList.toggle("grades", study.satisfaction.length > 0);
    const task = pictures === 1 ? "task_one" : "task";
    for (const told of document.querySelectorAll(".first")) told.textContent = word("natural");
    for (const told of document.querySelectorAll(".second")) told.textContent = word("unnatural");
    const each = conduct.faces_each ? fresh("any", 0).order.filter((name) => study.ratings.includes(name)).length : pictures;
    say("instructions", conduct.instructions || word(task, { n: each }));
    say("consent", conduct.consent);
    part("agreeing").hidden = !conduct.consent;
    part("agree").required = Boolean(conduct.consent);
    part("then").hidden = !study.satisfaction.length;
    part("window").hidden = fixed;
    const given = asked("rater", "PROLIFIC_PID", "participant", "workerId");
    const code = crypto.getRandomValues(new Uint8Array(4));
    part("rater").value = given ? given.toLowerCase() : kept("kogao-rater")
      || [...code].map((byte) => byte.toString(16).padStart(2, "0")).join("");
    // The browser doesn't check the pattern of a read-only code.
    part("rater").readOnly = Boolean(given) && part("rater").checkValidity();
    name_keys("fj");
    only("start");
    try {
      localStorage.setItem("kogao-study", "1");
    } catch (problem) {
      say("warning", word("keeps_nothing"));
    }
  }

  // The code of this tab, so that loading it again goes on; another rater opens another one.
  function kept(name, value) {
    try {
      if (value) sessionStorage.setItem(name, value);
      return sessionStorage.getItem(name);
    } catch (problem) {
      return null;
    }
  }

  function name_keys(keys) {
    const [natural, unnatural] = keys.toUpperCase();
    for (const told of document.querySelectorAll("kbd.natural")) told.textContent = natural;
    for (const told of document.querySelectorAll("kbd.unnatural")) told.textContent = unnatural;
    part("answers").classList.toggle("swapped", keys === "jf");
  }

  function open(rater) {
    saved = 0;
    session = stored(rater) || fresh(rater, parseInt(asked("number"), 10));
    kept("kogao-rater", rater);
    name_keys(session.keys || "fj");
    part("mine").textContent = word("code", { rater });
    const last = standing(session.records).pop();
    scale = !fixed && last && last.shown ? Math.max(...last.shown) / Math.max(...study.box) : null;
    show();
  }

  function full() {
    const page = document.documentElement;
    if (conduct.full_screen && page.requestFullscreen) page.requestFullscreen().catch(() => {});
  }

  // A break, or the end of practice, before the picture that is next.
  function pause(at) {
    const practised = at === study.practice.length && at > 0;
    const judged = at - study.practice.length;
    const due = conduct.break_every && judged > 0 && judged < study.ratings.length
      && judged % conduct.break_every === 0;
    if (pausedAt === at || !(practised || due) || !session.records.length) return false;
    pausedAt = at;
    only("pause");
    part("paused").textContent = word(practised ? "practised" : "break");
    part("so_far").textContent = practised ? "" : part("place").textContent;
    part("paused").focus();
    return true;
  }

  function show() {
    const at = done();
    const total = session.order.length;
    const practising = at < study.practice.length;
    trouble("");
    blocked = "";
    part("progress").max = total;
    part("progress").value = at;
    part("place").textContent = practising
      ? word("practice", { done: at, total: study.practice.length })
      : word("place", { done: at - study.practice.length, total: total - study.practice.length });
    part("back").disabled = !at;
    if (at >= total) return finish();
    if (pause(at)) return;
    only("judge");
    const grading = study.satisfaction.includes(session.order[at]);
    part("question").textContent = word(grading ? "ask_satisfied" : "ask_natural");
    part("scale").textContent = word("scale_satisfied");
    part("answers").hidden = grading;
    part("grades").hidden = !grading;
    touched = false;
    part("grade").value = 50;
    part("shown").textContent = "–";
    part("enter").disabled = true;
    part("question").focus();
    draw(session.order[at]);
    if (at + 1 < total) new Image().src = session.order[at + 1];
  }

  function trouble(text, full) {
    part("problem").textContent = text;
    part("full").hidden = !full;
    part("trouble").hidden = !text;
  }

  function fits(scale) {
    const [width, height] = study.box;
    return scale * width <= part("stage").clientWidth && scale * height <= part("stage").clientHeight;
  }

  function draw(name) {
    const picture = part("picture");
    ready = false;
    picture.hidden = true;
    picture.onload = lay;
    picture.onerror = () => trouble(word("missing", { name }));
    picture.src = name;
  }

  // The session's scale, CSS px a px of a picture; null where that is still to be found.
  function wanted() {
    if (!fixed) return scale || scales.find(fits) || scales[scales.length - 1];
    return parseFloat(conduct.size) / Math.max(...study.box);
  }

  // Why the picture can't be shown now; an empty text where it can.
  function obstacle() {
    const lacking = conduct.full_screen && !document.fullscreenElement;
    if (lacking) return word(document.documentElement.requestFullscreen ? "not_full" : "never_full");
    if (fits(scale)) return "";
    const need = study.box.map((side) => Math.round(scale * side));
    const room = [screen.width, screen.height];
    const never = need.some((side, axis) => side > room[axis]);
    return word(never ? "small_screen" : "larger", { size: need.join(" × "), screen: room.join(" × ") });
  }

  // Shows the picture at the session's scale; its time begins after the frame that paints it.
  function lay() {
    const picture = part("picture");
    const scaled = wanted();
    if (ready && scaled === scale && !obstacle()) return;
    scale = scaled;
    ready = false;
    const problem = obstacle();
    picture.hidden = Boolean(problem);
    // Another message stays until the next answer.
    if (problem !== blocked) trouble(problem, problem === word("not_full"));
    blocked = problem;
    if (problem) return;
    picture.width = scale * picture.naturalWidth;
    picture.height = scale * picture.naturalHeight;
    requestAnimationFrame(() => requestAnimationFrame((now) => {
      shownAt = now;
      away = 0;
      leftAt = present() ? null : now;
      ready = !picture.hidden;
    }));
  }

  function add(said) {
    // Another tab may have continued the session.
    const newest = stored(session.rater);
    const behind = newest && newest.records.length > session.records.length;
    if (behind) {
      session = newest;
    } else {
      session.records.push(Object.assign({ n: session.records.length + 1 }, said));
      store(session.rater, session);
    }
    show();
    if (behind) trouble(word("elsewhere"));
  }

  const present = () => document.visibilityState === "visible" && document.hasFocus();

  function attend() {
    const now = performance.now();
    if (leftAt !== null) away += now - leftAt;
    leftAt = present() ? null : now;
  }

  function answer(said) {
    if (!ready || part("judge").hidden) return;
    if (wanted() !== scale) return lay(); // moved to another screen
    attend();
    const took = performance.now() - shownAt - away;
    // What is pressed sooner was meant for the picture before.
    if (took < study.least_ms) return;
    const box = part("picture").getBoundingClientRect();
    add(Object.assign({ picture: session.order[done()] }, said, {
      ms: Math.round(took),
      away: Math.round(away),
      shown: [Math.round(box.width), Math.round(box.height)],
      window: [innerWidth, innerHeight],
      ratio: devicePixelRatio,
    }));
  }

  const grading = () => !part("grades").hidden;
  const judge = (said) => { if (!grading()) answer({ answer: said }); };
  const grade = () => { if (grading() && touched) answer({ grade: Number(part("grade").value) }); };
  const skip = () => { if (grading()) answer({ grade: null }); };

  function relay() {
    if (session && !part("judge").hidden && part("picture").complete) lay();
  }

  function back() {
    const last = standing(session.records).pop();
    if (last) add({ picture: last.picture, back: true });
  }

  function save() {
    const link = document.createElement("a");
    link.download = "ratings-" + session.rater + ".jsonl";
    link.href = URL.createObjectURL(new Blob([file(session)], { type: "application/jsonl" }));
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    saved = session.records.length;
  }

  function withdraw() {
    if (!confirm(word("withdraw_sure"))) return;
    store(session.rater, null);
    only("end");
    part("said").textContent = word("withdrawn");
    say("debriefing", conduct.debriefing);
    say("completion", "");
    for (const told of document.querySelectorAll("#end .save, #hand, #again, .withdraw")) told.remove();
    session = null;
    part("thanks").focus();
  }

  function finish() {
    only("end");
    part("said").textContent = word("said", { n: done() });
    say("debriefing", conduct.debriefing);
    say("completion", conduct.completion_code && word("completion", { code: conduct.completion_code }));
    part("hand").textContent = word("hand", { file: "ratings-" + session.rater + ".jsonl" });
    part("thanks").focus();
  }

  part("begin").addEventListener("submit", (event) => {
    event.preventDefault();
    full();
    open(part("rater").value);
  });
  part("agree").addEventListener("invalid", () => part("agree").setCustomValidity(word("disagrees")));
  part("agree").addEventListener("change", () => part("agree").setCustomValidity(""));
  part("resume").addEventListener("click", show);
  part("full").addEventListener("click", full);
  document.addEventListener("fullscreenchange", relay);
  part("grades").addEventListener("submit", (event) => {
    event.preventDefault();
    grade();
  });
  part("grade").addEventListener("input", () => {
    touched = true;
    part("shown").textContent = part("grade").value;
    part("enter").disabled = false;
  });
  part("natural").addEventListener("click", () => judge("natural"));
  part("unnatural").addEventListener("click", () => judge("unnatural"));
  part("skip").addEventListener("click", skip);
  part("back").addEventListener("click", back);
  part("again").addEventListener("click", back);
  for (const button of document.querySelectorAll(".save")) button.addEventListener("click", save);
  for (const change of ["focus", "blur"]) addEventListener(change, attend);
  document.addEventListener("visibilitychange", attend);
  for (const button of document.querySelectorAll(".withdraw")) button.addEventListener("click", withdraw);
  addEventListener("resize", relay);
  addEventListener("beforeunload", (event) => {
    if (session && session.records.length > saved) event.preventDefault();
  });
  document.addEventListener("keydown", (event) => {
    if (!part("pause").hidden && event.key === "Enter") {
      event.preventDefault();
      return show();
    }
    if (!session || part("judge").hidden && part("end").hidden || event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
    const [natural, unnatural] = session.keys || "fj";
    const keys = {
      [natural]: () => judge("natural"), [unnatural]: () => judge("unnatural"), s: skip, backspace: back,
    };
    const does = keys[event.key.toLowerCase()];
    if (does) {
      event.preventDefault();
      does();
    } else if (event.key === "Enter" && event.target === part("grade")) {
      event.preventDefault();
      grade();
    }
  });
  welcome();
}
