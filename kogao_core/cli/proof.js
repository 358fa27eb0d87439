"use strict";
const [form, answer, said, copied] =
  ["form", "answer", "said", "copied"].map((name) => document.getElementById(name));
const show = () => { answer.value = form.elements.dose.value; said.textContent = ""; };
form.addEventListener("change", show);
form.addEventListener("submit", (event) => {
  event.preventDefault();
  answer.select();
  if (document.execCommand("copy")) said.textContent = copied.textContent;
});
form.reset();
show();
