// Clicks through the page of CNCjs in a headless browser: see cncjs.py.
//
//     node cncjs.js BROWSER WEB_PORT SERIAL_PORT FOLDER

const puppeteer = require("puppeteer-core");
const path = require("path");

const [browserPath, webPort, serialPort, folder] = process.argv.slice(2);
const PATIENCE = 60000;

const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

/** What the page shows: state of the machine, and its work position. */
async function shown(page) {
  const text = await page.evaluate(() => document.body.innerText);
  const state = text.match(/State\s+(\S+)/);
  const place = ["X", "Y", "Z"].map((axis) => {
    const found = text.match(new RegExp(`${axis}\\s+mm\\s+(-?[\\d.]+)\\s+(-?[\\d.]+)`));
    return found ? Number(found[2]) : NaN;
  });
  return { state: state ? state[1] : "", place };
}

async function until(page, what, holds) {
  const began = Date.now();
  for (;;) {
    const now = await shown(page);
    if (holds(now)) {
      console.log(`${what}: ${now.state} at ${now.place.join(" ")}`);
      return now;
    }
    if (Date.now() - began > PATIENCE) throw new Error(`${what} does not come: ${JSON.stringify(now)}`);
    await sleep(100);
  }
}

/** Clicks a button by its text or title, once it may be. */
async function click(page, name) {
  const began = Date.now();
  for (;;) {
    const clicked = await page.evaluate((name) => {
      const named = (button) => button.innerText.trim() === name || button.title === name;
      const button = [...document.querySelectorAll("button")].find((b) => named(b) && !b.disabled && b.offsetParent);
      if (button) button.click();
      return Boolean(button);
    }, name);
    if (clicked) return;
    if (Date.now() - began > PATIENCE) throw new Error(`"${name}" cannot be clicked`);
    await sleep(100);
  }
}

/** Picks the port from the list. The list may open before the server has named the ports, or close again when it does: asked for again. */
async function choose(page, port) {
  const began = Date.now();
  for (;;) {
    await page.click(".Select-control, [class*=Select] input");
    await sleep(500);
    for (const option of await page.$$(".Select-option, [class*=option]")) {
      if ((await option.evaluate((e) => e.innerText)).includes(port)) return option.click();
    }
    if (Date.now() - began > PATIENCE) throw new Error(`${port} is not among the ports`);
    await page.keyboard.press("Escape");
    await sleep(500);
  }
}

const at = (place, goal) => place.every((x, axis) => Math.abs(x - goal[axis]) < 0.0015);

async function main() {
  const browser = await puppeteer.launch({
    executablePath: browserPath,
    args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
    defaultViewport: { width: 1600, height: 1100 },
  });
  try {
    const page = await browser.newPage();
    const picture = (name) => page.screenshot({ path: path.join(folder, `${name}.png`) });
    for (let tries = 0; ; tries++) {
      try {
        await page.goto(`http://127.0.0.1:${webPort}/`, { waitUntil: "networkidle2", timeout: PATIENCE });
        break;
      } catch (error) {
        if (tries > 30) throw error;
        await sleep(1000);
      }
    }

    // Connect.
    await page.waitForSelector(".Select-control, [class*=Select] input", { timeout: PATIENCE });
    await choose(page, serialPort);
    await click(page, "Open");
    await until(page, "connected", ({ state }) => state !== "" && state !== "–");
    await picture("1-connected");

    // Home: the machine stands 2 mm off its switches, which are 0.
    await click(page, "Homing");
    const home = await until(page, "homed", ({ state, place }) => state === "Idle" && at(place, [-2, -2, -2]));
    await picture("2-homed");

    // Jog.
    await click(page, "X-");
    await until(page, "jogged", ({ state, place }) => state === "Idle" && Math.abs(place[0] - home.place[0] + 1) < 0.0015);
    await click(page, "X0Y0");
    await until(page, "at work zero", ({ state, place }) => state === "Idle" && at(place, [0, 0, -2]));

    // Load, run, hold, resume, to the end.
    const input = await page.$("input[type=file]");
    await input.uploadFile(path.join(folder, "job.nc"));
    await click(page, "Run");
    await until(page, "runs", ({ state, place }) => state === "Run" && place[1] > 1);
    await click(page, "Feedhold");
    const held = await until(page, "holds", ({ state }) => state === "Hold");
    await sleep(500);
    const still = await shown(page);
    await sleep(1000);
    if (!at((await shown(page)).place, still.place)) throw new Error("it moves in a hold");
    await picture("3-held");
    await click(page, "Cycle Start");
    await until(page, "resumed", ({ state, place }) => state === "Run" && !at(place, held.place));
    await until(page, "ended", ({ state, place }) => state === "Idle" && at(place, [0, 0, -2]));
    await picture("4-ended");

    // Run again, and stop: nothing moves afterwards, and nothing of the file is left.
    await click(page, "Run");
    await until(page, "runs again", ({ state, place }) => state === "Run" && place[1] > 1);
    await click(page, "Pause");
    await until(page, "pauses", ({ state }) => state === "Hold");
    await click(page, "Stop");
    await until(page, "stopped", ({ state }) => state === "Idle" || state === "Alarm");
    const rest = await shown(page);
    await sleep(1500);
    if (!at((await shown(page)).place, rest.place)) throw new Error("it moves after a stop");
    await picture("5-stopped");

    // And it can be moved again.
    await click(page, "Unlock");
    await click(page, "X0Y0");
    await until(page, "back", ({ state, place }) => state === "Idle" && at(place, [0, 0, -2]));
    await picture("6-back");
  } catch (error) {
    const page = (await browser.pages()).pop();
    await page.screenshot({ path: path.join(folder, "failed.png") });
    throw error;
  } finally {
    await browser.close();
  }
}

main().then(
  () => console.log("CNCjs: done"),
  (error) => {
    console.error(`CNCjs: ${error.message}`);
    process.exit(1);
  },
);
