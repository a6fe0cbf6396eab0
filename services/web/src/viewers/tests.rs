//! Viewers get what is recorded, and nobody waits for them.

use super::{SharedStream, StreamChannel, ViewerServer, session};
use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::time::timeout;
use tokio_tungstenite::{WebSocketStream, client_async};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Error, Message};

/// Longer than anything takes that comes at all.
const PATIENCE: Duration = Duration::from_secs(20);

fn server() -> ViewerServer {
    ViewerServer::start(SocketAddr::from(([127, 0, 0, 1], 0))).expect("it listens")
}

fn channel(server: &ViewerServer, topic: &str) {
    server.channel(&StreamChannel { topic, schema_name: "cullet.Test", schema: b"a schema" });
}

type Viewer = WebSocketStream<TcpStream>;

async fn try_connect(
    server: &ViewerServer,
    headers: &[(&'static str, &str)],
) -> Result<Viewer, Error> {
    connect_to(server.address(), headers).await
}

async fn connect_to(
    address: SocketAddr,
    headers: &[(&'static str, &str)],
) -> Result<Viewer, Error> {
    let mut request = format!("ws://{address}").into_client_request().expect("a request");
    for (name, value) in headers {
        request.headers_mut().insert(*name, value.parse().expect("a header"));
    }
    let stream = TcpStream::connect(address).await.expect("connects");
    client_async(request, stream).await.map(|(viewer, _)| viewer)
}

const SDK: (&str, &str) = ("sec-websocket-protocol", "foxglove.sdk.v1");

async fn connect(server: &ViewerServer) -> Viewer {
    try_connect(server, &[SDK]).await.unwrap_or_else(|error| panic!("{error}"))
}

async fn next(viewer: &mut Viewer) -> Message {
    let next = timeout(PATIENCE, viewer.next()).await.expect("something comes");
    next.expect("it is open").expect("it is sound")
}

/// The next text.
async fn text(viewer: &mut Viewer) -> Value {
    loop {
        if let Message::Text(text) = next(viewer).await {
            return serde_json::from_str(&text).expect("JSON");
        }
    }
}

/// The next message: its subscription, its time and its bytes. No time that comes is before it.
async fn data(viewer: &mut Viewer) -> (u32, u64, Vec<u8>) {
    let mut now = 0;
    loop {
        let Message::Binary(frame) = next(viewer).await else { continue };
        let number = |at: usize| u64::from_le_bytes(frame[at..at + 8].try_into().expect("eight"));
        match frame[0] {
            2 => now = number(1),
            1 => {
                let subscription = u32::from_le_bytes(frame[1..5].try_into().expect("four"));
                let time = number(5);
                assert!(now == 0 || now >= time, "{now} {time}");
                return (subscription, time, frame[13..].to_vec());
            }
            other => panic!("a frame of kind {other}"),
        }
    }
}

async fn say(viewer: &mut Viewer, text: &Value) {
    viewer.send(Message::text(text.to_string())).await.expect("sends");
}

async fn subscribe(viewer: &mut Viewer, subscription: u32, channel: &Value) {
    let subscriptions = [json!({ "id": subscription, "channelId": channel })];
    say(viewer, &json!({ "op": "subscribe", "subscriptions": subscriptions })).await;
}

#[tokio::test]
async fn a_viewer_gets_what_is_recorded_and_a_late_one_the_latest() {
    let server = server();
    server.begin("pot");
    let mut early = connect(&server).await;
    let info = text(&mut early).await;
    assert_eq!((&info["op"], &info["name"]), (&json!("serverInfo"), &json!("cullet: pot")));
    assert_eq!(info["capabilities"], json!(["time"]));
    channel(&server, "/scene/pot");
    let told = text(&mut early).await;
    let advertised = &told["channels"][0];
    assert_eq!((&told["op"], &advertised["topic"]), (&json!("advertise"), &json!("/scene/pot")));
    assert_eq!(advertised["encoding"], "protobuf");
    assert_eq!(advertised["schemaEncoding"], "protobuf");
    assert_eq!(advertised["schemaName"], "cullet.Test");
    assert_eq!(advertised["schema"], "YSBzY2hlbWE=");
    server.message("/scene/pot", 1, b"before anybody asked");
    subscribe(&mut early, 5, &advertised["id"]).await;
    assert_eq!(data(&mut early).await, (5, 1, b"before anybody asked".to_vec()));
    server.message("/scene/pot", 2, b"two");
    server.message("/scene/pot", 3, b"three");
    assert_eq!(data(&mut early).await, (5, 2, b"two".to_vec()));
    assert_eq!(data(&mut early).await, (5, 3, b"three".to_vec()));
    // A late one gets the last message of a channel, and many lines of the log.
    channel(&server, "/log");
    for line in 0..500_u64 {
        server.message("/log", line, b"a line");
    }
    let mut late = connect(&server).await;
    text(&mut late).await;
    let told = text(&mut late).await;
    let ids: Vec<Value> =
        told["channels"].as_array().expect("a list").iter().map(|it| it["id"].clone()).collect();
    subscribe(&mut late, 1, &ids[0]).await;
    subscribe(&mut late, 2, &ids[1]).await;
    assert_eq!(data(&mut late).await, (1, 3, b"three".to_vec()));
    assert_eq!(data(&mut late).await, (2, 300, b"a line".to_vec()));
    assert_eq!((server.viewers(), server.left_out()), (2, 0));
}

/// Also where a text comes between, and where a channel's latest message is an old one.
#[tokio::test]
async fn the_time_of_a_run_never_goes_back() {
    let server = server();
    server.begin("pot");
    channel(&server, "/scene/a");
    channel(&server, "/scene/b");
    server.message("/scene/b", 3, b"still");
    server.message("/scene/a", 100, b"moved");
    let mut viewer = connect(&server).await;
    text(&mut viewer).await;
    let told = text(&mut viewer).await;
    subscribe(&mut viewer, 1, &told["channels"][0]["id"]).await;
    assert_eq!(data(&mut viewer).await, (1, 100, b"moved".to_vec()));
    channel(&server, "/scene/c");
    text(&mut viewer).await;
    subscribe(&mut viewer, 2, &told["channels"][1]["id"]).await;
    let mut times = Vec::new();
    loop {
        match next(&mut viewer).await {
            Message::Binary(frame) if frame[0] == 2 => {
                times.push(u64::from_le_bytes(frame[1..].try_into().expect("eight")));
            }
            Message::Binary(frame) => {
                assert_eq!(frame[13..], *b"still");
                break;
            }
            _ => {}
        }
    }
    assert!(times.iter().all(|time| *time >= 100), "{times:?}");
}

/// As where nothing was taken for too long: what speaks with it is dropped.
#[tokio::test]
async fn a_viewer_that_is_given_up_has_no_place_any_more() {
    let shared = Arc::new(SharedStream::default());
    let listener = TcpListener::bind(("127.0.0.1", 0)).await.expect("it listens");
    let address = listener.local_addr().expect("it has one");
    let serving = Arc::clone(&shared);
    let talk = tokio::spawn(async move {
        let (stream, _) = listener.accept().await.expect("one comes");
        session::talk(stream, serving).await;
    });
    let mut viewer = connect_to(address, &[SDK]).await.expect("it is taken");
    text(&mut viewer).await;
    assert_eq!(shared.state().clients.len(), 1);
    talk.abort();
    assert!(talk.await.expect_err("it was given up").is_cancelled());
    assert_eq!(shared.state().clients.len(), 0);
}

#[tokio::test]
async fn the_next_run_takes_the_place_of_the_one_before() {
    let server = server();
    server.begin("first");
    channel(&server, "/scene/a");
    let mut viewer = connect(&server).await;
    let first = text(&mut viewer).await;
    let told = text(&mut viewer).await;
    let old = told["channels"][0]["id"].clone();
    server.message("/scene/a", 3, b"old");
    subscribe(&mut viewer, 1, &old).await;
    assert_eq!(data(&mut viewer).await, (1, 3, b"old".to_vec()));
    server.begin("second");
    assert_eq!(text(&mut viewer).await, json!({ "op": "unadvertise", "channelIds": [old] }));
    let second = text(&mut viewer).await;
    assert_eq!(second["name"], "cullet: second");
    assert_ne!(second["sessionId"], first["sessionId"]);
    channel(&server, "/scene/a");
    let new = text(&mut viewer).await["channels"][0]["id"].clone();
    assert_ne!(new, old);
    server.message("/scene/a", 7, b"new");
    subscribe(&mut viewer, 1, &new).await;
    assert_eq!(data(&mut viewer).await, (1, 7, b"new".to_vec()));
}

/// A viewer that reads nothing holds nobody up, and is told what it missed.
#[tokio::test]
async fn nobody_waits_for_a_viewer() {
    let server = server();
    server.begin("pot");
    channel(&server, "/scene/pot");
    let mut viewer = connect(&server).await;
    text(&mut viewer).await;
    let told = text(&mut viewer).await;
    subscribe(&mut viewer, 1, &told["channels"][0]["id"]).await;
    server.message("/scene/pot", 0, b"there it is");
    data(&mut viewer).await;
    // Three times what may wait for it, and more than a socket holds.
    let large = vec![7; 8 << 20];
    for time in 1..=24 {
        server.message("/scene/pot", time, &large);
    }
    assert!(server.left_out() > 8, "{} left out", server.left_out());
    let mut missed = Value::Null;
    let mut times = Vec::new();
    while times.last() != Some(&24) {
        match next(&mut viewer).await {
            Message::Text(text) => missed = serde_json::from_str(&text).expect("JSON"),
            Message::Binary(frame) if frame[0] == 1 => {
                times.push(u64::from_le_bytes(frame[5..13].try_into().expect("eight")));
            }
            _ => {}
        }
    }
    assert!(times.is_sorted() && times.len() + server.left_out() as usize == 24, "{times:?}");
    assert_eq!((&missed["op"], &missed["level"]), (&json!("status"), &json!(1)));
    let said = missed["message"].as_str().unwrap_or_default();
    assert!(said.contains(&format!("{} messages were left out", server.left_out())), "{said}");
}

#[tokio::test]
async fn what_is_no_viewer_is_turned_away() {
    let server = server();
    let status = |tried: Result<Viewer, Error>| match tried {
        Err(Error::Http(response)) => response.status().as_u16(),
        Ok(_) => 101,
        Err(other) => panic!("{other}"),
    };
    let origin = |from: &'static str| ("origin", from);
    assert_eq!(status(try_connect(&server, &[SDK]).await), 101);
    let older = ("sec-websocket-protocol", "foxglove.websocket.v1");
    assert_eq!(status(try_connect(&server, &[older]).await), 101);
    let here = origin("http://localhost:8080");
    assert_eq!(status(try_connect(&server, &[SDK, here]).await), 101);
    let evil = origin("https://evil.example");
    assert_eq!(status(try_connect(&server, &[SDK, evil]).await), 403);
    let host = ("host", "evil.example");
    assert_eq!(status(try_connect(&server, &[SDK, host]).await), 421);
    assert_eq!(status(try_connect(&server, &[]).await), 400);
    // What a viewer says is read, and nothing of it is done but to subscribe.
    let mut viewer = connect(&server).await;
    text(&mut viewer).await;
    for (asked, answer) in [
        (json!({ "op": "advertise", "channels": [] }), "a run can only be watched"),
        (json!({ "op": "subscribe" }), "this is no request"),
        (
            json!({ "op": "subscribe", "subscriptions": [{ "id": 1, "channelId": 9 }] }),
            "there is no channel 9",
        ),
    ] {
        say(&mut viewer, &asked).await;
        let said = text(&mut viewer).await;
        assert!(said["message"].as_str().is_some_and(|it| it.contains(answer)), "{said}");
    }
}

#[tokio::test]
async fn a_server_that_ends_says_so() {
    let server = server();
    server.begin("pot");
    channel(&server, "/log");
    server.message("/log", 1, b"the end");
    let mut viewer = connect(&server).await;
    text(&mut viewer).await;
    let told = text(&mut viewer).await;
    subscribe(&mut viewer, 1, &told["channels"][0]["id"]).await;
    data(&mut viewer).await;
    let ended = tokio::task::spawn_blocking(move || drop(server));
    let closed = timeout(PATIENCE, async {
        while let Some(Ok(message)) = viewer.next().await {
            if message.is_close() {
                return true;
            }
        }
        false
    });
    assert!(closed.await.expect("in time"), "it is closed, not cut");
    ended.await.expect("ends");
}
