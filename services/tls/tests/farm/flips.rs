//! Bits of the ciphertext that turn over while both ends send and receive: the link ends, at both
//! ends and soon, with an error; what was received before is what was sent, and the process lives.
//!
//! `CULLET_FLIPS` is another number of them.

use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Semaphore;
use tokio::task::JoinSet;
use tokio::time::timeout;
use zenoh_link_commons::{ConfigurationInspector, LinkManagerUnicastTrait, LinkUnicast};
use zenoh_link_tls::{LinkManagerUnicastTls, TlsConfigurator};
use zenoh_protocol::core::EndPoint;

/// Links at once.
const BESIDE: usize = 6;
/// Bytes of the length and of the sealed record in which a handshake may lie: none is longer.
const HANDSHAKE: usize = 16_384;
/// Longest that the four tasks of a damaged link may go on.
const SOON: Duration = Duration::from_secs(20);

/// Certificates of one authority for both ends.
fn certificates(folder: &Path) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../deploy/certs.sh");
    let made = Command::new("sh").arg(script).arg(folder).args(["near", "far"]).status();
    assert!(made.is_ok_and(|status| status.success()), "deploy/certs.sh makes certificates");
}

/// An endpoint with the parameters that Zenoh would take from its configuration.
fn endpoint(place: &str, folder: &Path, name: &str) -> EndPoint {
    let file = |file: &str| format!("{:?}", folder.join(name).join(file).to_string_lossy());
    let mut config = zenoh_config::Config::default();
    for (key, value) in [
        ("root_ca_certificate", file("ca.pem")),
        ("listen_certificate", file("cert.pem")),
        ("listen_private_key", file("key.pem")),
        ("connect_certificate", file("cert.pem")),
        ("connect_private_key", file("key.pem")),
        ("enable_mtls", "true".to_owned()),
        ("close_link_on_expiration", "true".to_owned()),
    ] {
        let key = format!("transport/link/tls/{key}");
        config.insert_json5(&key, &value).expect("a setting");
    }
    let parameters = TlsConfigurator.inspect_config(&config).expect("parameters");
    format!("tls/{place}#{parameters}").parse().expect("an endpoint")
}

/// Carries one connection to `target` and turns one bit over, `after` bytes on the way up or down.
async fn proxy(target: String, up: bool, after: usize) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").await.expect("a port");
    let place = listener.local_addr().expect("an address").to_string();
    tokio::spawn(async move {
        let (near, _) = listener.accept().await.expect("a connection");
        let far = TcpStream::connect(target).await.expect("the listener");
        let (near_read, near_write) = near.into_split();
        let (far_read, far_write) = far.into_split();
        let carry = |mut from: tokio::net::tcp::OwnedReadHalf,
                     mut to: tokio::net::tcp::OwnedWriteHalf,
                     flips: bool| async move {
            let (mut block, mut passed) = (vec![0; 16_384], 0);
            while let Ok(length @ 1..) = from.read(&mut block).await {
                if flips && (passed..passed + length).contains(&after) {
                    block[after - passed] ^= 1 << (after % 8);
                }
                passed += length;
                if to.write_all(&block[..length]).await.is_err() {
                    break;
                }
            }
        };
        tokio::join!(carry(near_read, far_write, up), carry(far_read, near_write, !up));
    });
    place
}

/// Byte `at` of what an end sends.
fn byte(at: usize) -> u8 {
    (at % 251) as u8
}

/// Sends and receives until either fails, then closes as Zenoh does. Returns how much came over.
async fn busy(link: LinkUnicast) -> usize {
    let (sender, receiver) = (link.clone(), link.clone());
    let send = tokio::spawn(async move {
        let mut at = 0;
        loop {
            let block: Vec<u8> = (at..at + 60_000).map(byte).collect();
            if sender.write_all(&block, None).await.is_err() {
                break;
            }
            at += block.len();
        }
    });
    let receive = tokio::spawn(async move {
        let (mut block, mut at) = (vec![0; 65_535], 0);
        while let Ok(length @ 1..) = receiver.read(&mut block, None).await {
            let wrong = block[..length].iter().zip(at..).position(|(&got, at)| got != byte(at));
            assert_eq!(wrong, None, "a damaged record is taken, {at} bytes on");
            at += length;
        }
        at
    });
    let came = receive.await.expect("the reader does not panic");
    // The far end may still take what this one sends; the writer ends with the link.
    link.close().await.ok();
    send.await.expect("the writer does not panic");
    came
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn a_thousand_bits_that_turn_over_end_a_thousand_links_and_nothing_else() {
    let flips = std::env::var("CULLET_FLIPS").ok().and_then(|n| n.parse().ok()).unwrap_or(1_000);
    let folder = tempfile::tempdir().expect("a folder");
    certificates(folder.path());
    let (links, accepted) = flume::unbounded();
    let server = LinkManagerUnicastTls::new(links);
    let listening = server.new_listener(endpoint("127.0.0.1:0", folder.path(), "far")).await;
    let target = listening.expect("it listens").address().to_string();
    let client = Arc::new(LinkManagerUnicastTls::new(flume::unbounded().0));
    let free = Arc::new(Semaphore::new(BESIDE));
    let mut rounds = JoinSet::new();
    let mut far_ends = JoinSet::new();
    for round in 0..flips {
        let permit = Arc::clone(&free).acquire_owned().await.expect("open");
        let after = HANDSHAKE + 7_919 * (round % 97);
        let place = proxy(target.clone(), round % 2 == 0, after).await;
        let near = endpoint(&place, folder.path(), "near");
        let link = client.new_link(near).await.expect("a link");
        far_ends.spawn(timeout(SOON, busy(accepted.recv_async().await.expect("accepted"))));
        rounds.spawn(async move {
            let came = timeout(SOON, busy(link)).await.expect("the near end ends soon");
            drop(permit);
            came
        });
    }
    let mut came = 0;
    while let Some(round) = rounds.join_next().await {
        came += round.expect("no panic");
    }
    while let Some(round) = far_ends.join_next().await {
        came += round.expect("no panic").expect("the far end ends soon");
    }
    // Both directions were busy when the bit turned over.
    assert!(came > flips * 2 * HANDSHAKE, "{came} bytes came over {flips} links");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_the_link_does_not_serve_is_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    certificates(folder.path());
    let manager = LinkManagerUnicastTls::new(flume::unbounded().0);
    let good = endpoint("127.0.0.1:0", folder.path(), "far").to_string();
    let key = folder.path().join("far/key.pem").to_string_lossy().into_owned();
    let ca = folder.path().join("far/ca.pem").to_string_lossy().into_owned();
    for (from, to, words) in [
        ("enable_mtls=true", "enable_mtls=false", "both ends must show a certificate"),
        ("enable_mtls=true", "enable_mtls=maybe", "\"maybe\" is neither true nor false"),
        (key.as_str(), ca.as_str(), "ca.pem"),
        (key.as_str(), "/nowhere/key.pem", "/nowhere/key.pem"),
        ("root_ca_certificate_file=", "root_ca=", "root_ca_certificate_file is missing"),
    ] {
        let asked = good.replace(from, to);
        assert_ne!(asked, good, "{from} is in {good}");
        let refused = manager.new_listener(asked.parse().expect("an endpoint")).await;
        let text = refused.expect_err(to).to_string();
        assert!(text.contains(words), "{words:?} is not in {text:?}");
    }
    let mut config = zenoh_config::Config::default();
    config.insert_json5("transport/link/tls/listen_private_key_base64", "\"AAAA\"").expect("set");
    let text = TlsConfigurator.inspect_config(&config).expect_err("inline").to_string();
    assert!(text.contains("listen_private_key_base64"), "{text}");
}
