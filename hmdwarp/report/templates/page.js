
// The slider below a comparison covers its warped pictures with the truth, from the left. Without
// scripts it is hidden, and the pictures stand side by side.
for (const panels of document.querySelectorAll(".slides")) {
  const [truth, ...warped] = panels.querySelectorAll(".stack > :first-child img");
  for (const image of warped) {
    const over = truth.cloneNode();
    [over.className, over.alt] = ["over", ""];
    image.after(over);
  }
  const range = panels.nextElementSibling.querySelector("input");
  range.oninput = () => panels.style.setProperty("--truth", range.value / 100);
  range.oninput(); // a browser may have kept its value
  panels.style.setProperty("--ratio", truth.getAttribute("width") / truth.getAttribute("height"));
  panels.nextElementSibling.hidden = false;
}
addEventListener("keydown", ({ key }) => {
  for (const box of key === "Escape" ? document.querySelectorAll(".zoom :checked") : []) box.checked = false;
});
