use super::{
    AGEING_MS, Board, End, Event, How, MAX_KEPT, MAX_WAITING, MAX_WAITING_OF_ONE, No, Order, Wish,
};
use cullet_geometry::math::scramble;
use cullet_proto::service::State;

fn order(user: &str, priority: i32, at: u64) -> Order {
    Order { user: user.into(), priority, at, ..Order::default() }
}

fn take(board: &mut Board, events: impl IntoIterator<Item = Event>) {
    for event in events {
        board.apply(&event).unwrap_or_else(|no| panic!("{event:?}: {no}"));
    }
}

fn submit(board: &mut Board, order: Order) -> u64 {
    let events = board.submit(order, MAX_KEPT).expect("room");
    take(board, events);
    board.last
}

fn start(board: &mut Board, run: u64) {
    take(board, [Event::Started { run, folder: "f".into(), at: 1 }]);
}

fn end(board: &mut Board, run: u64, how: How) {
    take(board, [Event::Ended { run, how, end: End::default(), at: 2 }]);
}

fn state(board: &Board, run: u64) -> State {
    board.get(run).expect("known").state
}

#[test]
fn a_wish_is_done_when_the_attempt_ends_also_by_a_crash() {
    for (wish, want) in [(Wish::Cancel, State::Cancelled), (Wish::Pause, State::Paused)] {
        let mut board = Board::default();
        let run = submit(&mut board, order("a", 0, 0));
        start(&mut board, run);
        let event = match wish {
            Wish::Cancel => board.cancel(run, End::default(), 0),
            Wish::Pause => board.pause(run),
        };
        take(&mut board, event.expect("it may be"));
        assert_eq!(state(&board, run), State::Running, "it has not ended yet");
        let mut crashed = board.clone();
        take(&mut crashed, [Event::Returned { at: 3 }]);
        assert_eq!(state(&crashed, run), want);
        end(&mut board, run, How::Stopped);
        assert_eq!(state(&board, run), want);
    }
}

#[test]
fn a_crash_puts_what_went_on_back_into_the_queue_and_leaves_the_rest() {
    let mut board = Board::default();
    let runs: Vec<u64> = (0..4).map(|at| submit(&mut board, order("a", 0, at))).collect();
    start(&mut board, runs[0]);
    start(&mut board, runs[1]);
    end(&mut board, runs[1], How::Done);
    take(&mut board, [Event::Paused { run: runs[2] }, Event::Returned { at: 9 }]);
    let states: Vec<State> = runs.iter().map(|run| state(&board, *run)).collect();
    assert_eq!(states, [State::Queued, State::Done, State::Paused, State::Queued]);
    assert_eq!(board.next(0).map(|entry| entry.run), Some(runs[0]));
    assert_eq!(board.get(runs[0]).expect("known").attempt, 1);
}

#[test]
fn what_is_over_changes_by_retry_alone() {
    for (how, over) in
        [(How::Done, State::Done), (How::Failed, State::Failed), (How::Stalled, State::Stalled)]
    {
        let mut board = Board::default();
        let run = submit(&mut board, order("a", 0, 0));
        start(&mut board, run);
        end(&mut board, run, how);
        assert_eq!(state(&board, run), over);
        assert!(board.cancel(run, End::default(), 0).is_err() && board.pause(run).is_err());
        assert!(board.resume(run).is_err());
        let again = board.retry(run);
        assert_eq!(again.is_ok(), how != How::Done, "{how:?}");
        if let Ok(event) = again {
            take(&mut board, event);
            assert_eq!(state(&board, run), State::Queued);
        }
    }
}

#[test]
fn priority_goes_first_then_who_has_less_then_age_and_waiting_counts() {
    let mut board = Board::default();
    let first = submit(&mut board, order("a", 0, 0));
    let second = submit(&mut board, order("a", 0, 0));
    let other = submit(&mut board, order("b", 0, 0));
    let next = |board: &Board, now| board.next(now).map(|entry| entry.run);
    assert_eq!(next(&board, 0), Some(first));
    start(&mut board, first);
    assert_eq!(next(&board, 0), Some(other), "user a has one already");
    let urgent = submit(&mut board, order("a", 1, AGEING_MS));
    assert_eq!(next(&board, AGEING_MS - 1), Some(urgent));
    assert_eq!(
        next(&board, AGEING_MS),
        Some(other),
        "it has waited as long as a priority is worth"
    );
    take(&mut board, [Event::Paused { run: other }, Event::Paused { run: urgent }]);
    assert_eq!(next(&board, 0), Some(second));
}

#[test]
fn bounds_hold() {
    let mut board = Board::default();
    for at in 0..MAX_WAITING_OF_ONE as u64 {
        submit(&mut board, order("a", 0, at));
    }
    assert_eq!(board.submit(order("a", 0, 0), MAX_KEPT), Err(No::Full), "one user has enough");
    for at in MAX_WAITING_OF_ONE as u64..MAX_WAITING as u64 {
        submit(&mut board, order("b", 0, at));
    }
    assert_eq!(board.submit(order("c", 0, 0), MAX_KEPT), Err(No::Full), "it is full");
    assert_eq!(Board::default().submit(order("a", 101, 0), MAX_KEPT), Err(No::Priority));
    for k in 0..MAX_KEPT + 10 {
        let run = board.next(0).expect("one waits").run;
        start(&mut board, run);
        end(&mut board, run, How::Done);
        submit(&mut board, order(["c", "d"][k % 2], 0, 0));
    }
    assert_eq!(board.entries.len(), MAX_KEPT);
    // Those of c and d are forgotten, who have more than a has.
    assert!(board.get(1).is_ok() && state(&board, board.last) == State::Queued);
}

#[test]
fn who_hands_in_much_has_his_own_forgotten() {
    let mut board = Board::default();
    for k in 0..MAX_KEPT + 100 {
        let run = submit(&mut board, order(if k < 10 { "quiet" } else { "busy" }, 0, 0));
        start(&mut board, run);
        end(&mut board, run, How::Done);
    }
    assert_eq!(board.entries.len(), MAX_KEPT);
    assert!((1..=10).all(|run| board.get(run).is_ok()), "of the quiet one nothing is forgotten");
    assert!((11..=110).all(|run| board.get(run).is_err()), "and of the busy one the oldest");
}

#[test]
fn a_run_that_is_over_is_deleted_once_and_its_number_does_not_come_again() {
    let mut board = Board::default();
    let runs: Vec<u64> = (0..3).map(|at| submit(&mut board, order("a", 0, at))).collect();
    start(&mut board, runs[0]);
    take(&mut board, [Event::Paused { run: runs[1] }]);
    for (run, word) in runs.iter().zip(["running", "paused", "queued"]) {
        let said = board.delete(*run).expect_err("it is not over").to_string();
        assert!(said.contains(word) && said.contains("cancelled"), "{said}");
    }
    assert_eq!(board.delete(4), Err(No::Unknown(4)));
    let over = board.cancel(runs[2], End::default(), 5).expect("it may be");
    take(&mut board, over);
    let gone = board.delete(runs[2]).expect("it is over");
    take(&mut board, gone);
    assert_eq!(board.get(runs[2]), Err(No::Gone(3)));
    assert_eq!(board.delete(runs[2]), Ok(None), "asked again it is as it was");
    assert_eq!(board.leaving().map(|entry| entry.run).collect::<Vec<_>>(), [3]);
    take(&mut board, [Event::Removed { run: 3 }]);
    let mut anew = Board::default();
    take(&mut anew, board.told());
    assert_eq!((anew.leaving().count(), submit(&mut anew, order("a", 0, 9))), (0, 4));
}

/// Any history: an event that the board itself proposed fits, the same events make the same board,
/// and the board written anew is the board.
#[test]
fn the_same_events_make_the_same_board() {
    for seed in 0..200u64 {
        let (mut board, mut events, mut dice) = (Board::default(), Vec::new(), seed);
        for at in 0..60 {
            dice = scramble(dice.wrapping_add(1));
            let run = dice % 6 + 1;
            let how =
                [How::Done, How::Failed, How::Stalled, How::Stopped][(dice >> 8) as usize % 4];
            let proposed: Vec<Event> = match dice >> 16 & 7 {
                0 | 1 => board.submit(order("a", (dice % 3) as i32, at), 4).unwrap_or_default(),
                2 => board.cancel(run, End::default(), at).into_iter().flatten().collect(),
                3 => board.pause(run).into_iter().flatten().collect(),
                4 => board.resume(run).into_iter().flatten().collect(),
                5 => board.retry(run).into_iter().flatten().collect(),
                6 if dice >> 20 & 3 == 0 => vec![Event::Returned { at }],
                6 if dice >> 20 & 3 == 1 => board.delete(run).into_iter().flatten().collect(),
                6 if dice >> 20 & 3 == 2 => {
                    board.leaving().take(1).map(|e| Event::Removed { run: e.run }).collect()
                }
                6 => match board.entries().find(|entry| entry.state == State::Running) {
                    Some(e) => vec![Event::Ended { run: e.run, how, end: End::default(), at }],
                    None => Vec::new(),
                },
                _ => match board.next(at) {
                    Some(e) => vec![Event::Started { run: e.run, folder: "f".into(), at }],
                    None => Vec::new(),
                },
            };
            take(&mut board, proposed.clone());
            events.extend(proposed);
        }
        let (mut again, mut anew) = (Board::default(), Board::default());
        take(&mut again, events);
        assert_eq!(again, board, "seed {seed}");
        take(&mut anew, board.told());
        assert_eq!(anew, board, "seed {seed}");
    }
}
