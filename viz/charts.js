// Draws a chart in the element of this id, anew where there was one.
function plot(name, { data, layout }) {
  Plotly.react(name, data, layout, { responsive: true, displayModeBar: false });
}

// Buttons for the names in a choice; the one pressed before stays where it can.
function choose(id, names, then) {
  const row = document.getElementById(id);
  const before = row.querySelector("[aria-pressed=true]")?.textContent;
  const press = name => {
    for (const button of row.children) button.setAttribute("aria-pressed", button.textContent === name);
    then(name);
  };
  row.replaceChildren(...names.map(name => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = name;
    button.addEventListener("click", () => press(name));
    return button;
  }));
  press(names.includes(before) ? before : names[0]);
}
