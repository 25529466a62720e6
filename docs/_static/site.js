// what the theme leaves without a name, or out of the keyboard's reach
document.addEventListener("DOMContentLoaded", () => {
  for (const toggle of document.querySelectorAll("summary")) {
    if (!toggle.textContent.trim()) toggle.setAttribute("aria-label", "Pages below");
  }
  for (const link of document.querySelectorAll(".sphx-glr-thumbcontainer a")) {
    link.setAttribute("aria-label", link.textContent.trim());
  }
  for (const table of document.querySelectorAll("table.table")) {
    if (table.scrollWidth > table.clientWidth) table.tabIndex = 0;
  }
});
