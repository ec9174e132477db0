// Guided experiments: question, prediction, run, answer.

import { make } from "./page.js";

export class Lessons {
  /** begin: called with the settings of a lesson, starts its runs and returns whether it could. judge: asks for the answer. */
  constructor(lessons, begin, judge) {
    Object.assign(this, { lessons, begin, judge, lesson: null, guess: null, waiting: false });
    this.place = document.getElementById("lesson");
    this.list = document.getElementById("lesson-list");
    this.list.replaceChildren(...lessons.map((lesson, k) => {
      const button = make("button", { type: "button", textContent: `${k + 1}. ${lesson.title}` });
      button.addEventListener("click", () => this.choose(lesson));
      return make("li", {}, button);
    }));
  }

  choose(lesson) {
    Object.assign(this, { lesson, guess: null, waiting: false });
    [...this.list.querySelectorAll("button")].forEach((button, k) => {
      if (this.lessons[k] === lesson) button.setAttribute("aria-current", "true"); else button.removeAttribute("aria-current");
    });
    const go = make("button", { type: "button", className: "primary", textContent: "Run and see", disabled: true, id: "lesson-run" });
    const choices = make("fieldset", {}, make("legend", { textContent: "What do you expect?" }));
    for (const { key, text } of lesson.choices) {
      const radio = make("input", { type: "radio", name: "guess", value: key });
      radio.addEventListener("change", () => { this.guess = key; go.disabled = false; });
      choices.append(make("label", { className: "check" }, radio, text));
    }
    go.addEventListener("click", () => {
      if (!this.begin(lesson.settings)) return;
      this.waiting = true;
      this.say("The answer comes when the runs have ended. ", lesson.watch);
    });
    this.answer = make("div", { className: "answer", id: "lesson-answer", hidden: true });
    this.answer.setAttribute("role", "status");
    const runs = lesson.settings.map(({ label }, k) => `${"AB"[k]}: ${label}`).join(" · ");
    this.place.replaceChildren(make("p", { className: "question", textContent: lesson.question }), choices,
      make("p", { className: "hint", textContent: `Runs ${runs}` }), make("div", { className: "actions" }, go), this.answer);
  }

  say(bold, text) {
    this.answer.hidden = false;
    this.answer.replaceChildren(make("strong", { textContent: bold }), text);
  }

  /** Runs have ended: ask for the answer where the lesson waits for it. */
  ended(records) {
    if (!this.waiting) return;
    const own = records.slice(0, this.lesson.settings.length);
    if (own.length < this.lesson.settings.length || own.some((one) => !one || one.computing)) return;
    this.waiting = false;
    if (own.some((one) => one.state !== "over")) this.say("No answer. ", "A run broke off; see the message above.");
    else if (own.some((one) => one.outcome.stopped)) this.say("No answer. ", "A run was stopped before its end; run the lesson again.");
    else this.judge(this.lesson.name, own.map(({ name }) => name));
  }

  told({ lesson, answer, because, found: seen }) {
    if (!this.lesson || this.lesson.name !== lesson) return;
    const found = this.lesson.choices.find(({ key }) => key === answer);
    if (!found) this.say("The runs show none of these. ", "Were controls moved on the way? Run the lesson again.");
    else this.say(answer === this.guess ? `As you predicted: ${found.text}.` : `Not as you predicted: ${found.text}.`, `${seen} ${because}`);
  }
}
