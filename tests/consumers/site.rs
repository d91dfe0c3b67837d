//! A web site on this machine, and a browser with software WebGL that opens its pages.

use std::collections::BTreeMap;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Component, Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use crate::common;

/// How long a page may take, on a busy machine too.
const PATIENCE: Duration = Duration::from_secs(300);
/// How long the console may lag behind.
const LAG: Duration = Duration::from_secs(10);
/// What a page says on the console when it is done.
const ENDED: &str = "this page has ended";

/// One browser at a time: each draws with every core there is.
static ALONE: Mutex<()> = Mutex::new(());

pub fn chromium() -> Option<String> {
    let path = std::env::var("MIPFOLD_CHROMIUM").unwrap_or_else(|_| "chromium".into());
    if Command::new(&path).arg("--version").output().is_ok_and(|run| run.status.success()) {
        Some(path)
    } else {
        common::skip(&format!("{path} does not run (MIPFOLD_CHROMIUM)"))
    }
}

/// The folder of the npm package three.
pub fn three() -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("MIPFOLD_THREE") else {
        return common::skip("MIPFOLD_THREE is not set");
    };
    let folder = PathBuf::from(folder);
    assert!(folder.join("build/three.module.js").is_file(), "{}: no build/three.module.js", folder.display());
    Some(folder)
}

/// What a page found, line by line, and what was said on the console.
pub struct Seen {
    pub found: BTreeMap<String, String>,
    pub console: Vec<String>,
}

/// Opens `page`, which is a file of `tests/consumers` with its arguments behind a question mark, while `/files/` is
/// `files`. Nothing if there is no browser or no three.js.
pub fn open(page: &str, files: &Path) -> Option<Seen> {
    let (chromium, three) = (chromium()?, three()?);
    let alone = ALONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let pages = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/consumers");
    let folders = [("/three/", three), ("/files/", files.to_owned()), ("/", pages)];
    let (url, ends) = serve(folders, page);
    let folder = tempfile::tempdir().unwrap();
    let words = folder.path().join("words.txt");
    let mut run = Command::new(chromium)
        .args(["--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking"])
        .args(["--disable-component-update", "--disable-sync", "--use-angle=swiftshader"])
        .args(["--enable-unsafe-swiftshader", "--enable-logging=stderr", "--remote-debugging-port=0"])
        .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
        .arg(&url)
        .stdout(Stdio::null())
        .stderr(std::fs::File::create(&words).unwrap())
        .spawn()
        .unwrap();
    let found = ends.recv_timeout(PATIENCE);
    // The console is another process's: its last line is waited for.
    let said = || String::from_utf8_lossy(&std::fs::read(&words).unwrap()).into_owned();
    let start = Instant::now();
    while found.is_ok() && !said().contains(ENDED) && start.elapsed() < LAG {
        thread::sleep(Duration::from_millis(20));
    }
    run.kill().and_then(|()| run.wait()).unwrap();
    drop(alone);
    let said = said();
    let found = found.unwrap_or_else(|e| panic!("{url}: {e}\n{said}"));
    let pairs = found.lines().filter_map(|line| line.split_once('='));
    // Reading pictures back is what the pages are for; drivers warn that it is slow.
    let noise = [ENDED, "GPU stall due to ReadPixels"];
    let console = said.lines().filter(|line| line.contains("CONSOLE") && !noise.iter().any(|n| line.contains(n)));
    Some(Seen {
        found: pairs.map(|(name, value)| (name.into(), value.into())).collect(),
        console: console.map(str::to_owned).collect(),
    })
}

/// Answers at a port of this machine, for as long as the tests run: the address of `page`, and what pages found.
fn serve(folders: [(&'static str, PathBuf); 3], page: &str) -> (String, Receiver<String>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}/{page}", listener.local_addr().unwrap());
    let (found, ends) = channel();
    let site = Arc::new((folders, found));
    // A thread for each connection: browsers open some that they ask nothing of.
    thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let site = Arc::clone(&site);
            thread::spawn(move || answer(stream, &site.0, &site.1));
        }
    });
    (url, ends)
}

fn answer(mut stream: TcpStream, folders: &[(&str, PathBuf)], found: &Sender<String>) -> io::Result<()> {
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
        let below = |(prefix, folder): &(&str, PathBuf)| Some(folder.join(path.strip_prefix(prefix)?));
        let file = folders.iter().find_map(below);
        let inside = |file: &PathBuf| !file.components().any(|part| part == Component::ParentDir);
        file.filter(inside).and_then(|file| std::fs::read(file).ok())
    };
    let status = if body.is_some() { "200 OK" } else { "404 Not Found" };
    let kind = match path.rsplit('.').next() {
        Some("html") => "text/html",
        Some("js") => "text/javascript",
        Some("wasm") => "application/wasm",
        _ => "application/octet-stream",
    };
    let body = body.unwrap_or_default();
    write!(stream, "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\n", body.len())?;
    stream.write_all(b"Connection: close\r\n\r\n")?;
    stream.write_all(&body)
}
