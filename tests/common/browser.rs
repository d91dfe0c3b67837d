//! A local web site, and a browser with software WebGL that opens its pages.

use std::collections::BTreeMap;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Component, Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// How long a page may take.
const PATIENCE: Duration = Duration::from_secs(600);
/// How long the console may lag behind.
const LAG: Duration = Duration::from_secs(10);
/// What a page says on the console when it is done.
const ENDED: &str = "this page has ended";

/// One browser at a time in a test's program: each draws with every core there is.
static ALONE: Mutex<()> = Mutex::new(());

/// `MIPFOLD_CHROMIUM`, by default `chromium`; or why there is none.
pub fn chromium() -> Result<String, String> {
    let path = std::env::var("MIPFOLD_CHROMIUM").unwrap_or_else(|_| "chromium".into());
    if Command::new(&path).arg("--version").output().is_ok_and(|run| run.status.success()) {
        Ok(path)
    } else {
        Err(format!("{path} does not run (MIPFOLD_CHROMIUM)"))
    }
}

/// The folder of the npm package three, `MIPFOLD_THREE`; or why there is none.
pub fn three() -> Result<PathBuf, String> {
    let folder = PathBuf::from(std::env::var_os("MIPFOLD_THREE").ok_or("MIPFOLD_THREE is not set")?);
    for file in ["build/three.module.js", "examples/jsm/loaders/GLTFLoader.js", "examples/jsm/loaders/KTX2Loader.js"] {
        assert!(folder.join(file).is_file(), "{}: no {file}", folder.display());
    }
    Ok(folder)
}

/// The folder of another npm package, beside three's; or why there is none.
pub fn beside_three(package: &str) -> Result<PathBuf, String> {
    let folder = three()?.with_file_name(package);
    if folder.join("package.json").is_file() { Ok(folder) } else { Err(format!("no {package} beside MIPFOLD_THREE")) }
}

/// A file of a folder, by what stands behind `prefix` in the path of an address.
pub fn below(folder: &Path, prefix: &str, path: &str) -> Option<Vec<u8>> {
    let file = Path::new(path.strip_prefix(prefix)?);
    let inside = file.components().all(|part| matches!(part, Component::Normal(_)));
    inside.then(|| std::fs::read(folder.join(file)).ok()).flatten()
}

/// What a page found, line by line, and what was said on the console.
pub struct Seen {
    pub found: BTreeMap<String, String>,
    pub console: Vec<String>,
}

/// Answers at a local port, for as long as the tests run.
pub struct Site {
    address: String,
    /// What pages found: they post it to `/ended`, and say so on the console.
    ended: Receiver<String>,
}

type Find = dyn Fn(&str) -> Option<Vec<u8>> + Send + Sync;

impl Site {
    /// `find` has what stands at a path, which begins with `/`.
    pub fn new(find: impl Fn(&str) -> Option<Vec<u8>> + Send + Sync + 'static) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = format!("http://{}/", listener.local_addr().expect("an address"));
        let (found, ended) = channel();
        let find: Arc<Find> = Arc::new(find);
        // A thread for each connection: browsers open some that they ask nothing of.
        thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let (find, found) = (Arc::clone(&find), found.clone());
                thread::spawn(move || answer(stream, &*find, &found));
            }
        });
        Self { address, ended }
    }

    /// Opens a page, by its address below the site's, until it has sent what it found. No virtual time, as `--dump-dom`
    /// needs it: pictures are loaded and decoded aside of it.
    pub fn open(&self, chromium: &str, page: &str) -> Seen {
        let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
        // A page that fails twice says so twice.
        while self.ended.try_recv().is_ok() {}
        let folder = tempfile::tempdir().expect("a folder");
        let words = folder.path().join("words.txt");
        let mut run = Command::new(chromium)
            .args(["--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking"])
            .args(["--disable-component-update", "--disable-sync", "--use-angle=swiftshader"])
            .args(["--enable-unsafe-swiftshader", "--enable-logging=stderr", "--remote-debugging-port=0"])
            .arg("--window-size=1000,1500")
            .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
            .arg(format!("{}{page}", self.address))
            .stdout(Stdio::null())
            .stderr(std::fs::File::create(&words).expect("a file"))
            .spawn()
            .expect("a browser");
        let found = self.ended.recv_timeout(PATIENCE);
        // The console is another process's: its last line is waited for.
        let said = || String::from_utf8_lossy(&std::fs::read(&words).expect("its words")).into_owned();
        let start = Instant::now();
        while found.is_ok() && !said().contains(ENDED) && start.elapsed() < LAG {
            thread::sleep(Duration::from_millis(20));
        }
        run.kill().and_then(|()| run.wait()).expect("the browser's end");
        drop(alone);
        let said = said();
        let found = found.unwrap_or_else(|e| panic!("{page}: {e}\n{said}"));
        let pairs = found.lines().filter_map(|line| line.split_once('='));
        // Reading pictures back is what the pages are for; drivers warn that it is slow.
        let noise = [ENDED, "GPU stall due to ReadPixels"];
        let console = said.lines().filter(|line| line.contains("CONSOLE") && !noise.iter().any(|n| line.contains(n)));
        Seen {
            found: pairs.map(|(name, value)| (name.into(), value.into())).collect(),
            console: console.map(str::to_owned).collect(),
        }
    }
}

fn answer(mut stream: TcpStream, find: &Find, found: &Sender<String>) -> io::Result<()> {
    let mut reader = BufReader::new(stream.try_clone()?);
    let (mut first, mut length) = (String::new(), 0);
    reader.read_line(&mut first)?;
    loop {
        let mut line = String::new();
        if reader.read_line(&mut line)? == 0 || line.trim().is_empty() {
            break;
        }
        if let Some((_, value)) = line.split_once(':').filter(|(name, _)| name.eq_ignore_ascii_case("content-length")) {
            length = value.trim().parse().map_err(io::Error::other)?;
        }
    }
    let path = first.split([' ', '?']).nth(1).unwrap_or_default();
    let body = if path == "/ended" {
        let mut body = vec![0; length];
        reader.read_exact(&mut body)?;
        drop(found.send(String::from_utf8_lossy(&body).into_owned()));
        Some(Vec::new())
    } else {
        find(path)
    };
    let status = if body.is_some() { "200 OK" } else { "404 Not Found" };
    let kind = match path.rsplit(['.', '/']).next() {
        Some("" | "html") => "text/html",
        Some("js" | "mjs") => "text/javascript",
        Some("json") => "application/json",
        Some("png") => "image/png",
        Some("wasm") => "application/wasm",
        _ => "application/octet-stream",
    };
    let body = body.unwrap_or_default();
    write!(stream, "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\n", body.len())?;
    stream.write_all(b"Connection: close\r\n\r\n")?;
    stream.write_all(&body)
}
