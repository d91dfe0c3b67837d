(function () {
  "use strict";
  var at = function (id) { return document.getElementById("compare" + id); };
  var box = at(""), stage = at("-stage"), split = at("-split"), blink = at("-blink");
  var left = at("-left"), right = at("-right"), far = at("-far");
  var still = window.matchMedia("(prefers-reduced-motion: reduce)");
  var BLINK_MS = 600; // Below one change a second and a half: slow enough to look, far from harmful flashing.
  var timer = 0;

  var picture = function (name) {
    var img = document.createElement("img");
    img.className = "px " + name;
    img.draggable = false;
    stage.appendChild(img);
    return img;
  };
  var under = picture("right"), over = picture("left");

  var source = function (select) { return document.getElementById("p-" + select.value + "-" + far.value); };
  var name = function (select) { return select.options[select.selectedIndex].text; };
  var update = function () {
    [[under, right], [over, left]].forEach(function (pair) {
      var from = source(pair[1]);
      pair[0].src = from.src;
      pair[0].alt = from.alt;
    });
    stage.style.setProperty("--split", split.value + "%");
    split.setAttribute("aria-valuetext", split.value + "% " + name(left) + ", the rest " + name(right));
  };
  var stop = function () {
    clearInterval(timer);
    timer = 0;
    stage.classList.remove("blinking", "flipped");
    blink.setAttribute("aria-pressed", "false");
  };
  var flip = function () { stage.classList.toggle("flipped"); };

  [left, right, far].forEach(function (select) { select.addEventListener("change", update); });
  // Who moves the line wants to see it.
  split.addEventListener("input", function () { stop(); update(); });
  blink.addEventListener("click", function () {
    if (stage.classList.contains("blinking")) {
      stop();
      return;
    }
    stage.classList.add("blinking");
    blink.setAttribute("aria-pressed", "true");
    if (still.matches) {
      flip(); // No movement of its own: one press shows the other picture, the next one both.
    } else {
      timer = setInterval(flip, BLINK_MS);
    }
  });
  var drag = function (event) {
    var area = stage.getBoundingClientRect();
    split.value = Math.round(100 * (event.clientX - area.left) / area.width);
    update();
  };
  stage.addEventListener("pointerdown", function (event) {
    stop();
    stage.setPointerCapture(event.pointerId);
    drag(event);
  });
  stage.addEventListener("pointermove", function (event) {
    if (stage.hasPointerCapture(event.pointerId)) { drag(event); }
  });
  update();
  box.hidden = false;
}());
