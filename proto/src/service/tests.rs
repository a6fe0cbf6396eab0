use super::*;

#[test]
fn messages_are_the_text_that_the_protocol_page_shows() -> Result<(), WireError> {
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    let piece = BundlePiece { digest: "00".repeat(32), length: 5, index: 0, sum: None };
    let zeros = "00".repeat(32);
    let line = format!(r#"{{"digest":"{zeros}","length":5,"index":0}}"#);
    assert_eq!(text(seal(&piece, b"a\nbcd")?), format!("{line}\na\nbcd"));
    assert_eq!(text(seal(&PieceAnswer::Have, b"")?), r#"{"piece":"have"}"#);
    let missing = SubmitAnswer::Missing { pieces: vec![1, 2] };
    assert_eq!(text(seal(&missing, b"")?), r#"{"submit":"missing","pieces":[1,2]}"#);
    let accepted = SubmitAnswer::Accepted { run: 7 };
    assert_eq!(text(seal(&accepted, b"")?), r#"{"submit":"accepted","run":7}"#);
    assert_eq!(text(seal(&State::Stalled, b"")?), r#""stalled""#);
    let submit: Submit = open(br#"{"ticket":"a"}"#)?.0;
    assert_eq!(submit, Submit { ticket: "a".into(), ..Submit::default() });
    Ok(())
}

#[test]
fn bulk_comes_back_and_what_is_not_understood_is_refused() -> Result<(), WireError> {
    let which = Which { run: 3 };
    for bulk in [&b""[..], b"\n", b"x\ny"] {
        assert_eq!(open::<Which>(&seal(&which, bulk)?)?, (which, bulk));
    }
    assert!(matches!(open::<Which>(b"{"), Err(WireError::Header(_))));
    assert!(matches!(open::<Which>(b""), Err(WireError::Header(_))));
    assert!(matches!(open::<Which>(br#"{"run":1,"x":2}"#), Err(WireError::Header(_))));
    let long = vec![b' '; MAX_LINE + 1];
    assert!(matches!(open::<Which>(&long), Err(WireError::Limit { .. })));
    let digest = [0xab; 32];
    assert_eq!(digest_of(&hex_of(&digest))?, digest);
    for bad in ["", "ab", &"g".repeat(64), &"é".repeat(32)] {
        assert!(digest_of(bad).is_err(), "{bad}");
    }
    Ok(())
}

/// A coordinator of the same generation may be older, and not tell of jobs.
#[test]
fn a_position_is_the_text_that_the_protocol_page_shows() -> Result<(), WireError> {
    let old = r#"{"time":0.1,"end":2.0,"bodies":17,"fractures":1}"#;
    let more = r#","jobs":1,"permille":640,"step":24,"steps":480}"#;
    let line = old.replace('}', more);
    let (time, end, bodies, fractures) = (0.1, 2.0, 17, 1);
    let (jobs, permille) = (1, 640);
    let told = Position { time, end, bodies, fractures, jobs, permille, step: 24, steps: 480 };
    assert_eq!(seal(&told, b"")?, line.as_bytes());
    let known: Position = open(old.as_bytes())?.0;
    assert_eq!(known, Position { jobs: 0, permille: 0, step: 0, steps: 0, ..told });
    Ok(())
}

#[test]
fn words_are_those_of_json() -> Result<(), Box<dyn std::error::Error>> {
    use State::{Cancelled, Done, Failed, Paused, Queued, Running, Stalled};
    for state in [Queued, Running, Paused, Done, Failed, Stalled, Cancelled] {
        assert_eq!(serde_json::to_string(&state)?, format!("{:?}", state.word()));
    }
    Ok(())
}
