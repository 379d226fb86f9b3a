//! A page in headless Chromium, operated as by a person: with real key presses and clicks, through
//! the browser's debugging pipe.

use super::{Browser, PATIENCE};
use serde_json::{Value, json};
use std::fs::{self, File, OpenOptions};
use std::io::{Read, Write as _};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};

/// A page that is open in a browser.
pub(crate) struct Person {
    child: Child,
    to: File,
    answers: Receiver<Value>,
    last: u64,
    session: String,
    /// Address of the page's file.
    pub(crate) address: String,
    /// Messages on the console, and network requests.
    pub(crate) noise: Vec<String>,
}

impl Drop for Person {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Browser {
    /// Opens a page in a window of this width.
    pub(crate) fn open(&self, name: &str, html: &str, width: u32) -> Person {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("person-{name}"));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        let file = folder.join("page.html");
        fs::write(&file, html).unwrap();
        let pipes = ["to", "from"].map(|name| folder.join(name));
        let made = Command::new("mkfifo").args(&pipes).status().unwrap();
        assert!(made.success(), "no pipes");
        // The pipe is opened for both directions, so that neither side waits for the other.
        let both = |path: &Path| OpenOptions::new().read(true).write(true).open(path).unwrap();
        let (to, mut from) = (both(&pipes[0]), both(&pipes[1]));
        let child = Command::new("sh")
            .arg("-c")
            .arg(
                "in=$1; out=$2; program=$3; shift 3; exec \"$program\" \"$@\" 3<\"$in\" 4>\"$out\"",
            )
            .arg("sh")
            .args(&pipes)
            .arg(&self.program)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe"])
            // WebGL without a graphics card.
            .args(["--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
            .args(["--no-first-run", "--disable-background-networking", "--disable-dev-shm-usage"])
            .arg(format!("--user-data-dir={}", folder.join("profile").display()))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let (send, answers) = channel();
        thread::spawn(move || {
            let (mut message, mut bytes) = (Vec::new(), [0; 65536]);
            while let Ok(count) = from.read(&mut bytes) {
                for byte in &bytes[..count] {
                    if *byte != 0 {
                        message.push(*byte);
                    } else if let Ok(value) = serde_json::from_slice(&message) {
                        message.clear();
                        if send.send(value).is_err() {
                            return;
                        }
                    }
                }
            }
        });
        let address = format!("file://{}", file.display());
        let mut person = Person {
            child,
            to,
            answers,
            last: 0,
            session: String::new(),
            address,
            noise: Vec::new(),
        };
        let target = person.call("Target.createTarget", json!({ "url": "about:blank" }));
        let attached = json!({ "targetId": target["targetId"], "flatten": true });
        let session = person.call("Target.attachToTarget", attached);
        person.session = session["sessionId"].as_str().unwrap().to_owned();
        for domain in ["Runtime", "Log", "Network", "Page"] {
            person.call(&format!("{domain}.enable"), json!({}));
        }
        person.resize(width);
        let address = person.address.clone();
        person.go_to(&address);
        person
    }
}

impl Person {
    /// Calls a method of the browser and waits for its result.
    pub(crate) fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.last += 1;
        let mut message = json!({ "id": self.last, "method": method, "params": parameters });
        if !self.session.is_empty() {
            message["sessionId"] = json!(self.session);
        }
        self.to.write_all(message.to_string().as_bytes()).unwrap();
        self.to.write_all(&[0]).unwrap();
        loop {
            let answer = self.answers.recv_timeout(PATIENCE);
            let answer = answer.unwrap_or_else(|error| panic!("no answer to {method}: {error}"));
            if answer["id"] == self.last {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
            self.listen(&answer);
        }
    }

    fn listen(&mut self, event: &Value) {
        let parameters = &event["params"];
        let noise = match event["method"].as_str().unwrap_or_default() {
            "Runtime.consoleAPICalled" => format!("console: {}", parameters["args"]),
            "Runtime.exceptionThrown" => format!("exception: {}", parameters["exceptionDetails"]),
            "Log.entryAdded" => format!("log: {}", parameters["entry"]["text"]),
            "Page.javascriptDialogOpening" => format!("dialog: {}", parameters["message"]),
            "Network.requestWillBeSent" => {
                let url = parameters["request"]["url"].as_str().unwrap_or_default();
                let own = url.split('#').next() == Some(self.address.as_str());
                match own || url == "about:blank" {
                    true => return,
                    false => format!("request: {url}"),
                }
            }
            _ => return,
        };
        self.noise.push(noise);
    }

    /// Loads an address and waits until it is complete.
    pub(crate) fn go_to(&mut self, address: &str) {
        self.call("Page.navigate", json!({ "url": "about:blank" }));
        self.call("Page.navigate", json!({ "url": address }));
        self.wait_for("document.readyState === 'complete' && location.protocol === 'file:'");
    }

    pub(crate) fn resize(&mut self, width: u32) {
        let size =
            json!({ "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", size);
    }

    /// Value of an expression in the page.
    pub(crate) fn value(&mut self, expression: &str) -> Value {
        let asked = json!({ "expression": expression, "returnByValue": true });
        let found = self.call("Runtime.evaluate", asked);
        assert!(found["exceptionDetails"].is_null(), "{expression}: {found}");
        found["result"]["value"].clone()
    }

    /// Waits until an expression is true.
    #[track_caller]
    pub(crate) fn wait_for(&mut self, expression: &str) {
        let begun = Instant::now();
        while self.value(expression) != json!(true) {
            assert!(begun.elapsed() < PATIENCE, "never: {expression}; {:?}", self.noise);
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// Moves the mouse.
    pub(crate) fn point_at(&mut self, (x, y): (f64, f64)) {
        self.mouse("mouseMoved", (x, y), 0);
    }

    fn mouse(&mut self, kind: &str, (x, y): (f64, f64), buttons: u32) {
        let event = json!({
            "type": kind, "x": x, "y": y, "button": if kind == "mouseMoved" && buttons == 0 { "none" } else { "left" },
            "buttons": buttons, "clickCount": 1,
        });
        self.call("Input.dispatchMouseEvent", event);
    }

    pub(crate) fn click(&mut self, at: (f64, f64)) {
        self.point_at(at);
        self.mouse("mousePressed", at, 1);
        self.mouse("mouseReleased", at, 0);
    }

    pub(crate) fn drag(&mut self, from: (f64, f64), to: (f64, f64)) {
        self.point_at(from);
        self.mouse("mousePressed", from, 1);
        for k in 1..=5 {
            let t = f64::from(k) / 5.0;
            self.mouse(
                "mouseMoved",
                (from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1)),
                1,
            );
        }
        self.mouse("mouseReleased", to, 0);
    }

    /// Centre of an element after scrolling to it, px.
    pub(crate) fn centre(&mut self, selector: &str) -> (f64, f64) {
        let found = self.value(&format!(
            "(() => {{ const e = document.querySelector({}); e.scrollIntoView({{block: 'center', behavior: 'instant'}}); \
             const b = e.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; }})()",
            json!(selector)
        ));
        (found[0].as_f64().unwrap(), found[1].as_f64().unwrap())
    }

    pub(crate) fn press(&mut self, key: &str, code: u32) {
        for kind in ["rawKeyDown", "keyUp"] {
            let event =
                json!({ "type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code });
            self.call("Input.dispatchKeyEvent", event);
        }
    }
}
