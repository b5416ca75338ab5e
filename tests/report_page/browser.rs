//! A headless Chromium, driven over the DevTools protocol through its pipe: no port, no web socket.
//! <https://chromedevtools.github.io/devtools-protocol/>
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{ChildStdin, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock};

/// Runs before a page's own scripts: which of its timers still wait.
const TIMERS: &str = "(() => { const waiting = window.waitingTimers = new Set(), set = setTimeout, clear = clearTimeout;\
    window.setTimeout = (action, ...rest) => {\
        const timer = set((...values) => { waiting.delete(timer); action(...values); }, ...rest);\
        waiting.add(timer); return timer; };\
    window.clearTimeout = (timer) => { waiting.delete(timer); clear(timer); }; })();";

/// What never comes fails the test after this time, in seconds, instead of stopping it for ever.
const PATIENCE: u32 = 120;

/// A running browser; it ends when the pipe to it is closed.
struct Process {
    commands: ChildStdin,
    answers: BufReader<ChildStdout>,
    number: u64,
}

/// Those that no test uses at the moment: to start one costs more than most tests.
static IDLE: Mutex<Vec<Process>> = Mutex::new(Vec::new());

/// One tab, with a context (storage, permissions) of its own. Events pile up until they are asked for.
pub struct Browser {
    /// `None` once it has been given back.
    process: Option<Process>,
    context: Value,
    session: Option<String>,
    pub events: Vec<Value>,
}

/// Names under which systems install it; `BIPEDC_BROWSER` goes first.
fn executable() -> Option<String> {
    let wished = std::env::var("BIPEDC_BROWSER").ok();
    let known = ["chromium", "chromium-browser", "google-chrome", "chrome"].map(str::to_owned);
    let starts = |name: &String| {
        Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success())
    };
    wished.into_iter().chain(known).find(starts)
}

impl Process {
    /// `None` if none is installed. Its profile lies in the folder, and goes when the browser ends.
    fn start(folder: &Path) -> Option<Self> {
        static STARTED: AtomicUsize = AtomicUsize::new(0);
        static NAME: OnceLock<Option<String>> = OnceLock::new();
        let name = NAME.get_or_init(executable).as_ref()?;
        let number = STARTED.fetch_add(1, Ordering::Relaxed);
        let profile = folder.join(format!("profile-{}-{number}", std::process::id()));
        // The protocol lives on descriptors 3 and 4: the shell puts our pipes there.
        let mut process = Command::new("sh")
            .args(["-c", r#""$0" "$@" 3<&0 4>&1 </dev/null >/dev/null; rm -rf "$PROFILE""#, name])
            .env("PROFILE", &profile)
            .args(["--headless=new", "--remote-debugging-pipe", "--no-sandbox", "--disable-gpu"])
            .args(["--no-first-run", "--disable-background-networking", "--disable-component-update"])
            .args(["--hide-scrollbars", "--disable-dev-shm-usage"])
            .arg(format!("--user-data-dir={}", profile.display()))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let commands = process.stdin.take()?;
        let answers = BufReader::new(process.stdout.take()?);
        Some(Self { commands, answers, number: 0 })
    }
}

impl Browser {
    /// A tab in a browser that nobody uses, or in a new one. `None` if none is installed.
    pub fn start(folder: &Path) -> Option<Self> {
        let idle = IDLE.lock().unwrap().pop();
        let process = Some(idle.or_else(|| Process::start(folder))?);
        let mut browser = Self { process, context: Value::Null, session: None, events: Vec::new() };
        browser.context = browser.call("Target.createBrowserContext", json!({}))["browserContextId"].take();
        let tab = json!({ "url": "about:blank", "browserContextId": browser.context });
        let target = browser.call("Target.createTarget", tab)["targetId"].take();
        let attached = browser.call("Target.attachToTarget", json!({ "targetId": target, "flatten": true }));
        browser.session = attached["sessionId"].as_str().map(str::to_owned);
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        browser.call("Page.setLifecycleEventsEnabled", json!({ "enabled": true }));
        browser.call("Page.addScriptToEvaluateOnNewDocument", json!({ "source": TIMERS }));
        Some(browser)
    }

    /// Sends a command and waits for its answer.
    pub fn call(&mut self, method: &str, parameters: Value) -> Value {
        let process = self.process.as_mut().unwrap();
        process.number += 1;
        let number = process.number;
        let mut message = json!({ "id": number, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        let commands = &mut process.commands;
        commands.write_all(message.to_string().as_bytes()).and_then(|()| commands.write_all(b"\0")).unwrap();
        commands.flush().unwrap();
        loop {
            let mut answer = self.read();
            if answer["id"] == json!(number) {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].take();
            }
            self.keep(answer);
        }
    }

    /// What earlier tabs still have to say is not ours.
    fn keep(&mut self, event: Value) {
        if event["sessionId"].as_str() == self.session.as_deref() {
            self.events.push(event);
        }
    }

    fn read(&mut self) -> Value {
        let mut bytes = Vec::new();
        let count = self.process.as_mut().unwrap().answers.read_until(0, &mut bytes).unwrap();
        assert!(count > 0, "the browser went away");
        bytes.pop();
        serde_json::from_slice(&bytes).unwrap()
    }

    /// The value of an expression in the page; promises are awaited, exceptions fail the test.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let parameters = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let mut answer = self.call("Runtime.evaluate", parameters);
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {}", answer["exceptionDetails"]);
        answer["result"]["value"].take()
    }

    /// Sets window and theme, then opens an address and waits until it is loaded and drawn.
    pub fn open(&mut self, address: &str, (width, height): (u32, u32), theme: &str) {
        let phone = width < 500;
        let factor = if phone { 2 } else { 1 };
        self.call(
            "Emulation.setDeviceMetricsOverride",
            json!({ "width": width, "height": height, "deviceScaleFactor": factor, "mobile": phone }),
        );
        let scheme = json!([{ "name": "prefers-color-scheme", "value": theme }]);
        self.call("Emulation.setEmulatedMedia", json!({ "features": scheme }));
        let opened = self.call("Page.navigate", json!({ "url": address }));
        // The load of this document: events of those that were open before are among them too.
        let loaded = |event: &Value| {
            event["method"] == "Page.lifecycleEvent"
                && event["params"]["loaderId"] == opened["loaderId"]
                && event["params"]["name"] == "load"
        };
        while !self.events.iter().any(loaded) {
            let event = self.read();
            self.keep(event);
        }
        self.wait_for(&format!("document.documentElement.clientWidth === {width}"));
        self.settle();
    }

    /// Looks at every frame whether a condition holds, until it does.
    pub fn wait_for(&mut self, condition: &str) {
        self.evaluate(&format!(
            "new Promise((done, fail) => {{ const end = performance.now() + 1000 * {PATIENCE}; const look = () => {{\
             if ({condition}) done(); else if (performance.now() > end) fail(new Error('this never came'));\
             else requestAnimationFrame(look); }}; look(); }})"
        ));
    }

    /// Waits until none of the page's timers is left, and what they did is drawn.
    pub fn settle(&mut self) {
        self.wait_for("waitingTimers.size === 0");
        self.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))");
    }

    /// A key press on what has the focus.
    pub fn press(&mut self, key: &str) {
        let text = if key.chars().count() == 1 { key } else { "" };
        for kind in ["keyDown", "keyUp"] {
            let mut parameters = json!({ "type": kind, "key": key, "code": key });
            if kind == "keyDown" && !text.is_empty() {
                parameters["text"] = json!(text);
            }
            self.call("Input.dispatchKeyEvent", parameters);
        }
    }

    /// A mouse button pressed at one place (CSS pixels of the window) and released at another.
    pub fn drag(&mut self, from: (f64, f64), to: (f64, f64), shift: bool) {
        let modifiers = if shift { 8 } else { 0 };
        for (kind, (x, y)) in
            [("mouseMoved", from), ("mousePressed", from), ("mouseMoved", to), ("mouseReleased", to)]
        {
            self.call(
                "Input.dispatchMouseEvent",
                json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1, "modifiers": modifiers }),
            );
        }
    }

    /// Fingers put down, moved and lifted; places in CSS pixels of the window.
    pub fn touch(&mut self, from: &[(f64, f64)], to: &[(f64, f64)]) {
        self.call("Emulation.setTouchEmulationEnabled", json!({ "enabled": true, "maxTouchPoints": 2 }));
        let between = |part: f64| -> Vec<Value> {
            let mix = |a: f64, b: f64| a + part * (b - a);
            let places = from.iter().zip(to).enumerate();
            places.map(|(id, (a, b))| json!({ "x": mix(a.0, b.0), "y": mix(a.1, b.1), "id": id })).collect()
        };
        self.call("Input.dispatchTouchEvent", json!({ "type": "touchStart", "touchPoints": between(0.0) }));
        for step in 1..=10 {
            let points = between(0.1 * f64::from(step));
            self.call("Input.dispatchTouchEvent", json!({ "type": "touchMove", "touchPoints": points }));
        }
        self.call("Input.dispatchTouchEvent", json!({ "type": "touchEnd", "touchPoints": [] }));
        self.settle();
    }

    /// The whole page as PNG.
    pub fn screenshot(&mut self) -> Vec<u8> {
        let size = self.call("Page.getLayoutMetrics", json!({}))["cssContentSize"].clone();
        let clip = json!({ "x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1 });
        let answer = self.call(
            "Page.captureScreenshot",
            json!({ "format": "png", "captureBeyondViewport": true, "clip": clip, "optimizeForSpeed": true }),
        );
        decoded(&answer["data"])
    }

    /// The page as it is printed, A4.
    pub fn print(&mut self) -> Vec<u8> {
        let paper = json!({ "printBackground": false, "paperWidth": 8.27, "paperHeight": 11.69 });
        decoded(&self.call("Page.printToPDF", paper)["data"])
    }

    /// Errors and warnings of the console so far, and exceptions.
    pub fn complaints(&self) -> Vec<String> {
        let bad = |e: &&Value| match e["method"].as_str().unwrap_or("") {
            "Runtime.exceptionThrown" | "Log.entryAdded" => true,
            "Runtime.consoleAPICalled" => {
                matches!(e["params"]["type"].as_str(), Some("error" | "warning" | "assert"))
            }
            _ => false,
        };
        self.events.iter().filter(bad).map(Value::to_string).collect()
    }

    /// Addresses that were requested so far.
    pub fn requests(&self) -> Vec<String> {
        let sent = self.events.iter().filter(|e| e["method"] == "Network.requestWillBeSent");
        sent.filter_map(|e| e["params"]["request"]["url"].as_str()).map(str::to_owned).collect()
    }
}

fn decoded(data: &Value) -> Vec<u8> {
    use base64::Engine;
    base64::engine::general_purpose::STANDARD.decode(data.as_str().unwrap()).unwrap()
}

impl Drop for Browser {
    /// The tab is closed, and the browser waits for the next test; after a failure it ends.
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.session = None;
            self.call("Target.disposeBrowserContext", json!({ "browserContextId": self.context }));
            IDLE.lock().unwrap().extend(self.process.take());
        }
    }
}
