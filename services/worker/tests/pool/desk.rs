//! A client hands a scene in, follows it and fetches what came of it.

use crate::kit::{config, wait_for};
use cullet_coordinator::link::client::{Client, submit};
use cullet_coordinator::link::{Content, LinkError, Pool};
use std::time::Duration;

#[test]
fn a_scene_goes_in_lines_come_back_and_files_are_fetched() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let desk = pool.submissions();
    let endpoint = pool.endpoint().to_owned();
    let mesh: Vec<u8> = (0..3_000_000u32).map(|k| (k * 7 + k / 255) as u8).collect();
    let files = vec![("scene.toml".into(), b"[world]".to_vec()), ("m/a.obj".into(), mesh)];
    let sent = files.clone();
    let overrides = vec!["world.seed=2".to_owned()];
    let folder = std::env::temp_dir().join(format!("cullet-desk-{}", std::process::id()));
    let target = folder.clone();
    let client = std::thread::spawn(move || -> Result<_, LinkError> {
        let (client, handle) = submit(&endpoint, &sent, &overrides, 7)?;
        // Handed in again, it is the same one.
        assert_eq!(client.submit(&sent, &overrides, 7)?, handle);
        let mut lines = Vec::new();
        let outcome = client.follow(handle, |line| lines.push(line.to_owned()))?;
        let written = client.fetch(handle, &outcome, &target)?;
        Ok((lines, outcome.code, written))
    });
    let mut submission = None;
    wait_for("a submission", || {
        submission = submission.take().or_else(|| desk.next());
        submission.is_some()
    });
    let submission = submission.expect("a submission");
    assert_eq!(submission.bundle, files);
    assert_eq!(submission.overrides, ["world.seed=2"]);
    let lines: Vec<_> = (0..200).map(|k| format!("line {k}")).collect();
    for (index, line) in lines.iter().enumerate() {
        desk.progress(submission.id, line);
        if index % 50 == 0 {
            std::thread::sleep(Duration::from_millis(20));
        }
    }
    let source = std::env::temp_dir().join(format!("cullet-desk-{}.mcap", std::process::id()));
    let recording: Vec<u8> = (0..2_500_000u32).map(|k| (k ^ (k >> 9)) as u8).collect();
    std::fs::write(&source, &recording).expect("a file to serve");
    let result = vec![
        ("run.mcap".to_owned(), Content::Path(source.clone())),
        ("summary.json".to_owned(), Content::Bytes(b"{}".to_vec())),
        ("empty".to_owned(), Content::Bytes(Vec::new())),
    ];
    desk.finish(submission.id, result, 3);
    let (seen, code, written) = client.join().expect("no panic").expect("a whole exchange");
    assert_eq!((seen, code, written.len()), (lines, 3, 3));
    assert_eq!(std::fs::read(folder.join("run.mcap")).expect("fetched"), recording);
    assert_eq!(std::fs::read(folder.join("summary.json")).expect("fetched"), b"{}");
    assert!(desk.next().is_none());
    std::fs::remove_dir_all(folder).expect("our own folder");
    std::fs::remove_file(source).expect("our own file");
}

#[test]
fn paths_out_of_the_folder_and_unknown_numbers_are_refused() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let client = Client::connect(pool.endpoint()).expect("a client");
    let evil = vec![("../evil".to_owned(), Vec::new())];
    assert!(matches!(client.submit(&evil, &[], 1), Err(LinkError::Path { .. })));
    let handle = cullet_coordinator::link::client::Handle { id: 99 };
    let unknown = client.follow(handle, |_| {});
    assert!(matches!(unknown, Err(LinkError::Forgotten { id: 99, .. })), "{unknown:?}");
}

#[test]
fn a_client_of_nobody_is_told_so() {
    let probe = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let endpoint = format!("tcp/{}", probe.local_addr().expect("an address"));
    drop(probe);
    let client = Client::connect(&endpoint).and_then(|c| c.with("main", Duration::from_secs(1)));
    let said = client.and_then(|c| c.submit(&[("a".into(), vec![1])], &[], 1));
    let silent = matches!(&said, Err(LinkError::Silent { .. } | LinkError::Connect { .. }));
    assert!(silent, "{said:?}");
}
