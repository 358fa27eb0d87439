"use strict";
// One rating session in a browser. The upper half knows nothing of the page and is tested without one.
const study = "STUDY";

// plan.py has the same few lines: a session's order follows from the rater's code alone.
function mixed(text) {
  let value = 2166136261;
  for (let k = 0; k < text.length; k++) value = Math.imul(value ^ text.charCodeAt(k), 16777619);
  value = Math.imul(value ^ (value >>> 16), 0x85ebca6b);
  value = Math.imul(value ^ (value >>> 13), 0xc2b2ae35);
  return (value ^ (value >>> 16)) >>> 0;
}

function order(names, rater) {
  const places = new Map(names.map((name) => [name, mixed(rater + ":" + name)]));
  return [...names].sort((a, b) => places.get(a) - places.get(b) || (a < b ? -1 : 1));
}

function todo(rater) {
  return [...order(study.ratings, rater), ...order(study.satisfaction, rater)];
}

// The answers that stand, oldest first.
function standing(records) {
  const told = [];
  for (const record of records) record.back ? told.pop() : told.push(record);
  return told;
}

function file(rater, records) {
  const lines = [Object.assign({}, study.header, { rater }), ...records];
  return lines.map((line) => JSON.stringify(line) + "\n").join("");
}

if (typeof document !== "undefined") begin();

function begin() {
  const part = (id) => document.getElementById(id);
  const place = "kogao-study:" + study.study + ":";
  let rater = null;
  let records = [];
  let shownAt = 0;
  let ready = false;
  let touched = false;

  function stored(code) {
    try {
      return JSON.parse(localStorage.getItem(place + code) || "[]");
    } catch (problem) {
      return [];
    }
  }

  function codes() {
    const found = [];
    for (let k = 0; k < localStorage.length; k++) {
      const key = localStorage.key(k);
      if (key.startsWith(place)) found.push(key.slice(place.length));
    }
    return found.sort();
  }

  function say(id, text) {
    part(id).textContent = text;
    part(id).hidden = !text;
  }

  function only(id) {
    for (const main of document.querySelectorAll("main")) main.hidden = main.id !== id;
  }

  function welcome() {
    const pictures = study.ratings.length;
    part("count").textContent = pictures + (pictures === 1 ? " picture" : " pictures");
    part("then").hidden = !study.satisfaction.length;
    const drawn = crypto.getRandomValues(new Uint8Array(4));
    part("rater").value = [...drawn].map((byte) => byte.toString(16).padStart(2, "0")).join("");
    let sessions = [];
    try {
      sessions = codes();
      localStorage.setItem("kogao-study", "1");
    } catch (problem) {
      say("warning", "This browser keeps nothing for a file: do the session in one go, and save at the end.");
    }
    part("unfinished").hidden = !sessions.length;
    part("sessions").replaceChildren(...sessions.map(entry));
    only("start");
  }

  function entry(code) {
    const item = document.createElement("li");
    const button = document.createElement("button");
    const done = standing(stored(code)).length;
    button.textContent = code + ": " + done + " of " + todo(code).length;
    button.addEventListener("click", () => open(code));
    item.append(button);
    return item;
  }

  function open(code) {
    rater = code;
    try {
      records = stored(code);
    } catch (problem) {
      records = [];
    }
    show();
  }

  function show() {
    const list = todo(rater);
    const done = standing(records).length;
    part("progress").max = list.length;
    part("progress").value = done;
    part("place").textContent = done + " of " + list.length;
    part("back").disabled = !done;
    if (done >= list.length) return finish();
    only("judge");
    const grading = done >= study.ratings.length;
    part("question").textContent = grading
      ? "How satisfied are you with this picture of yourself?"
      : "Does this face look natural or unnatural?";
    part("answers").hidden = grading;
    part("grades").hidden = !grading;
    touched = false;
    part("grade").value = 50;
    part("shown").textContent = "–";
    part("enter").disabled = true;
    part("question").focus();
    draw(list[done]);
    if (done + 1 < list.length) new Image().src = list[done + 1];
  }

  function draw(name) {
    const picture = part("picture");
    ready = false;
    picture.classList.add("waiting");
    picture.onload = () => {
      picture.classList.remove("waiting");
      ready = true;
      say("trouble", "");
      requestAnimationFrame(() => { shownAt = performance.now(); });
    };
    picture.onerror = () => say("trouble", "The picture " + name + " is missing: copy the whole folder again.");
    picture.src = name;
  }

  function add(said) {
    // Another tab may have gone on with the same session.
    const kept = stored(rater);
    if (kept.length > records.length) {
      records = kept;
      show();
      return say("trouble", "This session went on in another tab; here it goes on from there.");
    }
    const next = [...records, Object.assign({ n: records.length + 1 }, said)];
    try {
      localStorage.setItem(place + rater, JSON.stringify(next));
    } catch (problem) {
      say("trouble", "This browser can't keep the answers: don't close it before you have saved them.");
    }
    records = next;
    show();
  }

  function answer(said) {
    if (!ready || part("judge").hidden) return;
    ready = false;
    const done = standing(records).length;
    const ms = Math.max(0, Math.round(performance.now() - shownAt));
    add(Object.assign({ picture: todo(rater)[done] }, said, { ms }));
  }

  const grading = () => !part("grades").hidden;
  const judge = (said) => { if (!grading()) answer({ answer: said }); };
  const grade = () => { if (grading() && touched) answer({ grade: Number(part("grade").value) }); };
  const skip = () => { if (grading()) answer({ grade: null }); };

  function back() {
    const told = standing(records);
    if (told.length) add({ picture: told[told.length - 1].picture, back: true });
  }

  function save() {
    const link = document.createElement("a");
    link.download = "ratings-" + rater + ".jsonl";
    link.href = URL.createObjectURL(new Blob([file(rater, records)], { type: "application/jsonl" }));
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  }

  function finish() {
    only("end");
    part("said").textContent = standing(records).length + " answers are kept under the code " + rater + ".";
    part("file").textContent = "ratings-" + rater + ".jsonl";
    part("thanks").focus();
  }

  part("begin").addEventListener("submit", (event) => {
    event.preventDefault();
    open(part("rater").value);
  });
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
  document.addEventListener("keydown", (event) => {
    if (part("judge").hidden || event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
    const keys = { f: () => judge("natural"), j: () => judge("unnatural"), s: skip, backspace: back };
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
