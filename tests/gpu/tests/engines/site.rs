//! A web site on this machine, and a browser that opens its pages.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::Duration;

use mipfold_gpu_tests::translate::Language;

use super::{helpers, snippet};

/// How long the page may take, on a busy machine too.
const PATIENCE: Duration = Duration::from_secs(600);

/// What a page found, line by line, and what was said on the console.
pub struct Driven {
    pub found: BTreeMap<String, String>,
    pub console: Vec<String>,
}

/// Opens a page of the site in a browser with software WebGL, until it has sent what it found. No virtual time, as
/// `--dump-dom` needs it: pictures are loaded and decoded aside of it.
pub fn open(chromium: &str, url: &str, site: &Receiver<String>) -> Driven {
    let folder = tempfile::tempdir().expect("a folder");
    let words = folder.path().join("words.txt");
    let mut run = Command::new(chromium)
        .args(["--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking"])
        .args([
            "--disable-component-update",
            "--disable-sync",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
        ])
        .args(["--enable-logging=stderr", "--remote-debugging-port=0", "--window-size=1000,1500"])
        .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
        .arg(url)
        .stdout(Stdio::null())
        .stderr(fs::File::create(&words).expect("a file"))
        .spawn()
        .expect("a browser");
    let found = site.recv_timeout(PATIENCE);
    // The console is another process's.
    thread::sleep(Duration::from_millis(500));
    run.kill().and_then(|()| run.wait()).expect("the browser's end");
    let words = String::from_utf8_lossy(&fs::read(&words).expect("its words")).into_owned();
    let found = found.unwrap_or_else(|e| panic!("{url}: {e}\n{words}"));
    let pairs = found.lines().filter_map(|line| line.split_once('='));
    // Reading pictures back is what the page is for; drivers warn that it is slow.
    let console = words.lines().filter(|l| l.contains("CONSOLE") && !l.contains("GPU stall due to ReadPixels"));
    Driven {
        found: pairs.map(|(name, value)| (name.into(), value.into())).collect(),
        console: console.map(str::to_owned).collect(),
    }
}

/// What the page asks for.
pub struct Site {
    three: PathBuf,
    texts: BTreeMap<&'static str, (&'static str, Vec<u8>)>,
    found: Sender<String>,
}

impl Site {
    fn new(three: PathBuf, found: Sender<String>) -> Self {
        let manifest = r#"{ "wrap": "repeat", "maps": [
            { "role": "normal", "container": "png", "files": ["0.png", "1.png", "2.png"] },
            { "role": "roughness", "container": "png", "files": ["0.png", "1.png", "2.png"] }
        ] }"#;
        let module = snippet("three/mipfold.js").into_bytes();
        let texts = BTreeMap::from([
            ("/", ("text/html", include_bytes!("three.html").to_vec())),
            ("/ended", ("text/plain", Vec::new())),
            ("/mipfold.js", ("text/javascript", module)),
            ("/helpers.glsl", ("text/plain", helpers("geometric_aa_screen", Language::Glsl).into_bytes())),
            ("/mips/manifest.json", ("application/json", manifest.into())),
            ("/mips/0.png", ("image/png", png(4, [200, 128, 255]))),
            ("/mips/1.png", ("image/png", png(2, [20, 128, 255]))),
            ("/mips/2.png", ("image/png", png(1, [90, 60, 255]))),
        ]);
        Self { three, texts, found }
    }

    /// Answers at a port of this machine, for as long as the test runs: its address, and what pages found.
    pub fn serve(three: PathBuf) -> (String, Receiver<String>) {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = format!("http://{}", listener.local_addr().expect("an address"));
        let (found, receiver) = channel();
        let site = Arc::new(Self::new(three, found));
        // A thread for each connection: browsers open some that they ask nothing of.
        thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let site = Arc::clone(&site);
                thread::spawn(move || site.answer(stream));
            }
        });
        (address, receiver)
    }

    fn answer(&self, mut stream: TcpStream) -> io::Result<()> {
        let mut reader = BufReader::new(stream.try_clone()?);
        let (mut first, mut length) = (String::new(), 0);
        reader.read_line(&mut first)?;
        loop {
            let mut line = String::new();
            if reader.read_line(&mut line)? == 0 || line.trim().is_empty() {
                break;
            }
            if let Some((name, value)) = line.split_once(':').filter(|(n, _)| n.eq_ignore_ascii_case("content-length"))
            {
                length = value.trim().parse().unwrap_or_else(|e| panic!("{name}: {e}"));
            }
        }
        let path = first.split([' ', '?']).nth(1).unwrap_or_default();
        if path == "/ended" {
            let mut body = vec![0; length];
            reader.read_exact(&mut body)?;
            drop(self.found.send(String::from_utf8_lossy(&body).into_owned()));
        }
        let built = path.strip_prefix("/three/build/").filter(|name| !name.contains('/'));
        let module = built.and_then(|name| fs::read(self.three.join("build").join(name)).ok());
        let module = module.map(|body| ("text/javascript", body));
        let (status, (kind, body)) = match self.texts.get(path).cloned().or(module) {
            Some(found) => ("200 OK", found),
            None => ("404 Not Found", ("text/plain", Vec::new())),
        };
        let length = body.len();
        write!(stream, "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n")?;
        stream.write_all(b"Connection: close\r\n\r\n")?;
        stream.write_all(&body)
    }
}

/// A square PNG of one colour, in stored blocks.
fn png(side: u32, colour: [u8; 3]) -> Vec<u8> {
    let row: Vec<u8> = std::iter::once(0).chain((0..side).flat_map(|_| colour)).collect();
    let raw = row.repeat(side as usize);
    let adler =
        raw.iter().fold((1u32, 0u32), |(a, b), &v| ((a + u32::from(v)) % 65521, (a + b + u32::from(v)) % 65521));
    let length = u16::try_from(raw.len()).expect("a small picture");
    let mut packed = vec![0x78, 1, 1];
    packed.extend(length.to_le_bytes());
    packed.extend((!length).to_le_bytes());
    packed.extend(&raw);
    packed.extend((adler.1 << 16 | adler.0).to_be_bytes());
    let mut header = Vec::new();
    header.extend(side.to_be_bytes());
    header.extend(side.to_be_bytes());
    header.extend([8, 2, 0, 0, 0]);
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    for (kind, data) in [(b"IHDR", header), (b"IDAT", packed), (b"IEND", Vec::new())] {
        let checked: Vec<u8> = kind.iter().chain(&data).copied().collect();
        let crc = checked.iter().fold(!0u32, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 == 1 { c >> 1 ^ 0xEDB8_8320 } else { c >> 1 })
        });
        file.extend((data.len() as u32).to_be_bytes());
        file.extend(checked);
        file.extend((!crc).to_be_bytes());
    }
    file
}
