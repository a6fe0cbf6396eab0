//! What strangers may send to the address where a coordinator answers metrics and health.
#![cfg(target_os = "linux")]

use crate::common;

use common::{Cullet, Going, free_endpoint, free_port, until};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Longest that another client may wait for an answer, whatever strangers send.
const SOON: Duration = Duration::from_secs(3);
/// Longest life of a connection, with room for a machine that has other things to do.
const LIFE: Duration = Duration::from_secs(20);
/// Most threads and memory that strangers may cost \[KiB\].
const MORE: (u64, u64) = (8, 32 << 10);

const HEALTH: &[u8] = b"GET /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n";

struct Coordinator {
    process: Going,
    place: SocketAddr,
    /// Threads and memory before anybody came.
    before: (u64, u64),
}

impl Coordinator {
    fn start() -> Self {
        let place = SocketAddr::from(([127, 0, 0, 1], free_port()));
        let (endpoint, metrics) = (free_endpoint(), place.to_string());
        let call = ["coordinator", "--listen", &endpoint, "--metrics", &metrics];
        let process = Cullet::new(&call).spawn();
        let mut all = Self { process, place, before: (0, 0) };
        until("it answers", LIFE, || all.is_well());
        // What it needs from the second request on is there.
        assert!((0..100).all(|_| all.is_well()));
        all.before = all.held();
        all
    }

    /// Threads and memory that it holds \[KiB\].
    fn held(&self) -> (u64, u64) {
        let path = format!("/proc/{}/status", self.process.id());
        let text = std::fs::read_to_string(path).unwrap_or_default();
        let number = |key: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(key));
            line.and_then(|line| line.split_whitespace().next()?.parse().ok())
        };
        (number("Threads:").unwrap_or(u64::MAX), number("VmRSS:").unwrap_or(u64::MAX))
    }

    fn connect(&self) -> std::io::Result<TcpStream> {
        let stream = TcpStream::connect_timeout(&self.place, SOON)?;
        stream.set_read_timeout(Some(SOON))?;
        stream.set_write_timeout(Some(SOON))?;
        Ok(stream)
    }

    /// What comes back for these bytes, until the end or silence.
    fn ask(&self, bytes: &[u8]) -> String {
        let mut told = Vec::new();
        if let Ok(mut stream) = self.connect() {
            let _may_be_reset =
                stream.write_all(bytes).and_then(|()| stream.read_to_end(&mut told));
        }
        String::from_utf8_lossy(&told).into_owned()
    }

    fn is_well(&self) -> bool {
        let asked = Instant::now();
        self.ask(HEALTH).starts_with("HTTP/1.1 200 OK") && asked.elapsed() < SOON
    }

    /// While strangers are at it: it lives, another client is answered, and little is held.
    fn bears(&mut self, what: &str) {
        let well = self.is_well();
        assert!(!self.process.ended(), "{what}: it ended: {}", self.process.stderr());
        assert!(well, "{what}: another client has no answer within {SOON:?}");
        let ((threads, memory), before) = (self.held(), self.before);
        println!("{what}: {threads} threads of {}, {memory} KiB of {}", before.0, before.1);
        assert!(threads <= before.0 + MORE.0, "{what}: {threads} threads, {} before", before.0);
        assert!(memory <= before.1 + MORE.1, "{what}: {memory} KiB, {} before", before.1);
    }
}

#[test]
fn a_body_of_any_length_is_refused_and_not_waited_for() {
    let mut coordinator = Coordinator::start();
    for length in ["1", "99999999999", "18446744073709551614", "18446744073709551615"] {
        let head = format!("GET /healthz HTTP/1.1\r\nHost: x\r\nContent-Length: {length}\r\n\r\n");
        let told = coordinator.ask(head.as_bytes());
        assert!(told.starts_with("HTTP/1.1 4"), "{length}: {told}");
        coordinator.bears(&format!("a body of {length} bytes"));
    }
    let chunked =
        b"POST /metrics HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\nffffffff\r\n";
    let told = coordinator.ask(chunked);
    assert!(told.starts_with("HTTP/1.1 413"), "{told}");
    coordinator.bears("chunks");
}

#[test]
fn requests_in_a_row_keep_nobody_out() {
    let mut coordinator = Coordinator::start();
    let all = b"GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n".repeat(100_000);
    let mut greedy: Vec<TcpStream> = Vec::new();
    for _ in 0..8 {
        let mut stream = coordinator.connect().expect("a connection");
        // Nothing is read. It may be closed before all is written.
        stream.set_write_timeout(Some(Duration::from_millis(500))).expect("a limit");
        let _closed = stream.write_all(&all);
        greedy.push(stream);
        coordinator.bears("requests in a row");
    }
    let told = coordinator.ask(&HEALTH.repeat(50));
    assert_eq!(told.matches("HTTP/1.1 ").count(), 1, "one connection, one request: {told}");
}

#[test]
fn a_header_without_an_end_is_not_held() {
    let mut coordinator = Coordinator::start();
    let mut stream = coordinator.connect().expect("a connection");
    stream.write_all(b"GET /healthz HTTP/1.1\r\nX: ").expect("a beginning");
    let (piece, mut sent) = (vec![b'a'; 1 << 20], 0);
    while sent < 300 && stream.write_all(&piece).is_ok() {
        sent += 1;
    }
    coordinator.bears("a header of 300 MB");
    assert!(sent < 64, "{sent} MiB of a header were taken");
    let many = format!("GET / HTTP/1.1\r\n{}\r\n", "a: b\r\n".repeat(2000));
    for head in [many, format!("GET /{} HTTP/1.1\r\n\r\n", "a".repeat(60_000))] {
        let told = coordinator.ask(head.as_bytes());
        assert!(told.is_empty() || told.starts_with("HTTP/1.1 4"), "{told}");
        coordinator.bears("a large head");
    }
}

#[test]
fn who_holds_connections_open_keeps_nobody_out() {
    let mut coordinator = Coordinator::start();
    let idle: Vec<TcpStream> = (0..1500).filter_map(|_| coordinator.connect().ok()).collect();
    assert!(idle.len() > 1000, "there are {} connections", idle.len());
    coordinator.bears("1500 idle connections");
    let fds = std::fs::read_dir(format!("/proc/{}/fd", coordinator.process.id()));
    let fds = fds.expect("its files").count();
    assert!(fds < 300, "{fds} files are open");
    // Each sends a letter from time to time, and is heard out for so long and no longer.
    let mut slow: Vec<TcpStream> = (0..200).filter_map(|_| coordinator.connect().ok()).collect();
    for letter in b"GET /healthz" {
        for stream in &mut slow {
            let _closed = stream.write_all(&[*letter]);
        }
        coordinator.bears("slow requests");
        sleep(Duration::from_millis(100));
    }
    let mut last = slow.pop().expect("a connection");
    let begun = Instant::now();
    until("the last of them is closed", LIFE, || {
        let _closed = last.write_all(b"a");
        !matches!(last.peek(&mut [0; 1]), Err(error) if error.kind() == WAITS)
    });
    println!("closed after {:.1} s", begun.elapsed().as_secs_f64());
    let again: Vec<TcpStream> = (0..100).filter_map(|_| coordinator.connect().ok()).collect();
    common::signal(coordinator.process.id(), "TERM");
    let code = coordinator.process.wait(LIFE);
    assert_eq!(code, Some(0), "it does not leave: {}", coordinator.process.stderr());
    drop((idle, again));
}

const WAITS: std::io::ErrorKind = std::io::ErrorKind::WouldBlock;

#[test]
fn what_is_no_plain_request_gets_one_answer_or_none() {
    let mut coordinator = Coordinator::start();
    let inner = "GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n";
    let post = "POST /healthz HTTP/1.1\r\nHost: x\r\n";
    let forms = [
        format!("{post}Content-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n{inner}"),
        format!("{post}Transfer-Encoding: chunked\r\nContent-Length: 5\r\n\r\n0\r\n\r\n{inner}"),
        format!("{post}Transfer-Encoding: xchunked\r\n\r\n0\r\n\r\n{inner}"),
        format!("{post}Transfer-Encoding: chunked, identity\r\n\r\n0\r\n\r\n{inner}"),
        format!("{post}Transfer-Encoding:\x0bchunked\r\n\r\n0\r\n\r\n{inner}"),
        format!("{post}Content-Length: 0\r\nContent-Length: 35\r\n\r\n{inner}"),
        format!("{post}Content-Length: 0, 35\r\n\r\n{inner}"),
        format!("{post}Content-Length: +0\r\n\r\n{inner}"),
        format!("{post}Content-Length: -1\r\n\r\n{inner}"),
        format!("{post}Content-Length: 0x23\r\n\r\n{inner}"),
        format!("{post}Content-Length : 35\r\n\r\n{inner}"),
        format!("{post} Content-Length: 35\r\n\r\n{inner}"),
        format!("{post}Content-Length:\r\n 35\r\n\r\n{inner}"),
        format!("{post}X: a\r\r\nContent-Length: 35\r\n\r\n{inner}"),
        format!("{post}Expect: 100-continue\r\nContent-Length: 35\r\n\r\n{inner}"),
        format!(
            "GET /healthz HTTP/1.1\r\nHost: x\r\nUpgrade: h2c\r\nConnection: Upgrade\r\n\r\n{inner}"
        ),
        format!("CONNECT /metrics HTTP/1.1\r\nHost: x\r\n\r\n{inner}"),
        format!("GET /healthz HTTP/9.9\r\nHost: x\r\n\r\n{inner}"),
        format!("GET /healthz\r\n\r\n{inner}"),
        format!("GET  /healthz HTTP/1.1\r\n\r\n{inner}"),
        format!("G\0T /healthz HTTP/1.1\r\n\r\n{inner}"),
        "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n".to_owned(),
    ];
    for form in &forms {
        let told = coordinator.ask(form.as_bytes());
        assert!(told.matches("HTTP/1.").count() <= 1, "{form:?}: {told}");
        assert!(!told.contains("cullet_runs"), "{form:?}: the second was answered: {told}");
        let read = told.is_empty() || told.starts_with("HTTP/1.1 ");
        assert!(read, "{form:?}: {told}");
        coordinator.bears("no plain request");
    }
    let mut draw = common::farm::Draw(24);
    for length in [1, 16, 5_000, 1 << 20] {
        let garbage: Vec<u8> = (0..length).map(|_| draw.below(256) as u8).collect();
        let told = coordinator.ask(&garbage);
        assert!(told.is_empty() || told.starts_with("HTTP/1.1 4"), "{told}");
        // What a TLS client says first.
        let told =
            coordinator.ask(&[&[0x16, 3, 1, 2, 0, 1, 0, 1, 0xfc, 3, 3][..], &garbage].concat());
        assert!(told.is_empty() || told.starts_with("HTTP/1.1 4"), "{told}");
        coordinator.bears("garbage");
    }
}

#[test]
fn whoever_asks_plainly_is_answered() {
    let coordinator = Coordinator::start();
    let ask = |line: &str| {
        coordinator.ask(format!("{line}\r\nHost: x\r\nConnection: close\r\n\r\n").as_bytes())
    };
    until("there are metrics", LIFE, || ask("GET /metrics HTTP/1.1").contains("cullet_runs{"));
    let told = ask("GET /metrics HTTP/1.1");
    let (head, body) = told.split_once("\r\n\r\n").expect("a head and a body");
    let head = head.to_lowercase();
    assert!(head.starts_with("http/1.1 200 ok"), "{head}");
    assert!(head.contains("content-type: text/plain; version=0.0.4; charset=utf-8"), "{head}");
    assert!(head.contains(&format!("content-length: {}", body.len())), "{head}");
    let head = ask("HEAD /metrics HTTP/1.1");
    assert!(head.starts_with("HTTP/1.1 200") && head.ends_with("\r\n\r\n"), "{head}");
    for (line, want) in [
        ("GET /readyz HTTP/1.0", "HTTP/1.0 200"),
        ("GET /healthz?full HTTP/1.1", "HTTP/1.1 200"),
        ("GET /other HTTP/1.1", "HTTP/1.1 404"),
        ("DELETE /metrics HTTP/1.1", "HTTP/1.1 405"),
    ] {
        let told = ask(line);
        assert!(told.starts_with(want), "{line}: {told}");
    }
}

#[test]
fn metrics_beyond_this_machine_are_asked_for_in_so_many_words() {
    for (address, more) in [("0.0.0.0", None), ("[::]", None), ("0.0.0.0", Some("--insecure"))] {
        let (endpoint, metrics) = (free_endpoint(), format!("{address}:{}", free_port()));
        let call = ["coordinator", "--listen", &endpoint, "--metrics", &metrics];
        let mut process = Cullet::new(&call).args(more.as_slice()).spawn();
        if more.is_some() {
            let place = metrics.replace("0.0.0.0", "127.0.0.1");
            until("it listens", LIFE, || TcpStream::connect(&place).is_ok());
            continue;
        }
        assert_eq!(process.wait(LIFE), Some(64), "{metrics}: {}", process.stderr());
        let said = process.stderr();
        assert!(said.contains(&metrics) && said.contains("--insecure"), "{said}");
    }
}
