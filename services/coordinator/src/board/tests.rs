use super::{
    AGEING_MS, AttemptEnd, Board, BoardEvent, MAX_KEPT, MAX_WAITING, MAX_WAITING_OF_ONE, No,
    Reached, RunEnd, RunEntry, Submission, Wish,
};
use cullet_geometry::math::scramble;
use cullet_proto::service::State;
use std::collections::VecDeque;

fn order(user: &str, priority: i32, at: u64) -> Submission {
    Submission { user: user.into(), priority, at, ..Submission::default() }
}

fn take(board: &mut Board, events: impl IntoIterator<Item = BoardEvent>) {
    for event in events {
        board.apply(&event).unwrap_or_else(|no| panic!("{event:?}: {no}"));
    }
}

fn submit(board: &mut Board, order: Submission) -> u64 {
    let events = board.submit(order, MAX_KEPT).expect("room");
    take(board, events);
    board.last
}

fn start(board: &mut Board, run: u64) {
    take(board, [BoardEvent::Started { run, folder: "f".into(), at: 1 }]);
}

fn end(board: &mut Board, run: u64, how: AttemptEnd) {
    take(board, [BoardEvent::Ended { run, how, end: RunEnd::default(), at: 2 }]);
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
            Wish::Cancel => board.cancel(run, RunEnd::default(), 0),
            Wish::Pause => board.pause(run),
        };
        take(&mut board, event.expect("it may be"));
        assert_eq!(state(&board, run), State::Running, "it has not ended yet");
        let mut crashed = board.clone();
        take(&mut crashed, [BoardEvent::Returned { at: 3 }]);
        assert_eq!(state(&crashed, run), want);
        end(&mut board, run, AttemptEnd::Stopped);
        assert_eq!(state(&board, run), want);
    }
}

#[test]
fn a_crash_puts_what_went_on_back_into_the_queue_and_leaves_the_rest() {
    let mut board = Board::default();
    let runs: Vec<u64> = (0..4).map(|at| submit(&mut board, order("a", 0, at))).collect();
    start(&mut board, runs[0]);
    start(&mut board, runs[1]);
    end(&mut board, runs[1], AttemptEnd::Done);
    take(&mut board, [BoardEvent::Paused { run: runs[2] }, BoardEvent::Returned { at: 9 }]);
    let states: Vec<State> = runs.iter().map(|run| state(&board, *run)).collect();
    assert_eq!(states, [State::Queued, State::Done, State::Paused, State::Queued]);
    assert_eq!(board.next(0).map(|entry| entry.run), Some(runs[0]));
    assert_eq!(board.get(runs[0]).expect("known").attempt, 1);
}

#[test]
fn what_is_over_changes_by_retry_alone() {
    for (how, over) in [
        (AttemptEnd::Done, State::Done),
        (AttemptEnd::Failed, State::Failed),
        (AttemptEnd::Stalled, State::Stalled),
    ] {
        let mut board = Board::default();
        let run = submit(&mut board, order("a", 0, 0));
        start(&mut board, run);
        end(&mut board, run, how);
        assert_eq!(state(&board, run), over);
        assert!(board.cancel(run, RunEnd::default(), 0).is_err() && board.pause(run).is_err());
        assert!(board.resume(run).is_err());
        let again = board.retry(run);
        assert_eq!(again.is_ok(), how != AttemptEnd::Done, "{how:?}");
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
    take(&mut board, [BoardEvent::Paused { run: other }, BoardEvent::Paused { run: urgent }]);
    assert_eq!(next(&board, 0), Some(second));
}

/// With one run at a time and with two, however long whose runs have waited.
#[test]
fn who_hands_in_much_does_not_go_before_who_hands_in_one() {
    for slots in [1, 2] {
        for ages in [0, 5, 50].map(|steps| steps * AGEING_MS) {
            let mut board = Board::default();
            for _ in 0..6 {
                submit(&mut board, order("a", 0, 0));
            }
            let mut going = VecDeque::new();
            let mut began = Vec::new();
            let mut now = 0;
            for round in 0..8 {
                if round == 1 {
                    now += ages;
                    submit(&mut board, order("b", 0, now));
                    submit(&mut board, order("b", 0, now));
                }
                while going.len() < slots {
                    let Some(run) = board.next(now).map(|entry| entry.run) else { break };
                    let (folder, at) = (run.to_string(), now);
                    take(&mut board, [BoardEvent::Started { run, folder, at }]);
                    began.push(board.get(run).expect("it is there").order.user.clone());
                    going.push_back(run);
                }
                now += 1000;
                end(&mut board, going.pop_front().expect("one goes on"), AttemptEnd::Done);
            }
            // Those that began before b came, and then in turn; in steps of ten minutes what
            // waited since a's last began may count once for a.
            let began: String = began[slots..].concat();
            let late = began.find('b').expect("b has its turn");
            assert!(late <= 1, "{slots} at once, after {ages} ms: {began}");
            assert!(began[late..].starts_with("bab"), "{slots} at once, after {ages} ms: {began}");
        }
    }
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
        end(&mut board, run, AttemptEnd::Done);
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
        end(&mut board, run, AttemptEnd::Done);
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
    take(&mut board, [BoardEvent::Paused { run: runs[1] }]);
    for (run, word) in runs.iter().zip(["running", "paused", "queued"]) {
        let said = board.delete(*run).expect_err("it is not over").to_string();
        assert!(said.contains(word) && said.contains("cancelled"), "{said}");
    }
    assert_eq!(board.delete(4), Err(No::Unknown(4)));
    let over = board.cancel(runs[2], RunEnd::default(), 5).expect("it may be");
    take(&mut board, over);
    let gone = board.delete(runs[2]).expect("it is over");
    take(&mut board, gone);
    assert_eq!(board.get(runs[2]), Err(No::Gone(3)));
    assert_eq!(board.delete(runs[2]), Ok(None), "asked again it is as it was");
    assert_eq!(board.leaving().map(|entry| entry.run).collect::<Vec<_>>(), [3]);
    take(&mut board, [BoardEvent::Removed { run: 3 }]);
    let mut anew = Board::default();
    take(&mut anew, board.to_events());
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
                [AttemptEnd::Done, AttemptEnd::Failed, AttemptEnd::Stalled, AttemptEnd::Stopped]
                    [(dice >> 8) as usize % 4];
            let proposed: Vec<BoardEvent> = match dice >> 16 & 7 {
                0 | 1 => board.submit(order("a", (dice % 3) as i32, at), 4).unwrap_or_default(),
                2 => board.cancel(run, RunEnd::default(), at).into_iter().flatten().collect(),
                3 => board.pause(run).into_iter().flatten().collect(),
                4 => board.resume(run).into_iter().flatten().collect(),
                5 => board.retry(run).into_iter().flatten().collect(),
                6 if dice >> 20 & 3 == 0 => {
                    let reached = Reached { time: dice >> 40 & 3, settled: 0 };
                    let died = |e: &RunEntry| BoardEvent::Died { run: e.run, reached };
                    board.running().map(died).chain([BoardEvent::Returned { at }]).collect()
                }
                6 if dice >> 20 & 3 == 1 => board.delete(run).into_iter().flatten().collect(),
                6 if dice >> 20 & 3 == 2 => {
                    board.leaving().take(1).map(|e| BoardEvent::Removed { run: e.run }).collect()
                }
                6 => match board.entries().find(|entry| entry.state == State::Running) {
                    Some(e) => {
                        vec![BoardEvent::Ended { run: e.run, how, end: RunEnd::default(), at }]
                    }
                    None => Vec::new(),
                },
                _ => match board.next(at) {
                    Some(e) => {
                        vec![BoardEvent::Started { run: e.run, folder: "f".into(), at }]
                    }
                    None => Vec::new(),
                },
            };
            take(&mut board, proposed.clone());
            events.extend(proposed);
        }
        let (mut again, mut anew) = (Board::default(), Board::default());
        take(&mut again, events);
        assert_eq!(again, board, "seed {seed}");
        take(&mut anew, board.to_events());
        assert_eq!(anew, board, "seed {seed}");
    }
}

fn die(board: &mut Board, reached: &[(u64, u64)]) -> Vec<u64> {
    for (run, time) in reached {
        let reached = Reached { time: *time, settled: 0 };
        take(board, [BoardEvent::Died { run: *run, reached }]);
    }
    let deadly = board.deadly();
    for run in &deadly {
        end(board, *run, AttemptEnd::Stalled);
    }
    take(board, [BoardEvent::Returned { at: 3 }]);
    deadly
}

/// Begins all that may.
fn begin(board: &mut Board) -> Vec<u64> {
    let mut begun = Vec::new();
    while let Some(run) = board.next(0).map(|entry| entry.run) {
        start(board, run);
        begun.push(run);
    }
    begun
}

/// One of three runs kills the coordinator at 70 wherever it comes by; the others end once they
/// are left alone.
#[test]
fn a_run_that_kills_the_coordinator_ends_as_stalled_and_the_others_end() {
    let mut board = Board::default();
    let runs: Vec<u64> = (0..3).map(|at| submit(&mut board, order("a", 0, at))).collect();
    let guilty = runs[1];
    let place = |run: u64| if run == guilty { 70 } else { 50 };
    let mut lives = Vec::new();
    for _ in 0..20 {
        let going = begin(&mut board);
        if going.is_empty() {
            break;
        }
        lives.push(going.clone());
        if going.contains(&guilty) {
            let at: Vec<(u64, u64)> = going.iter().map(|run| (*run, place(*run))).collect();
            die(&mut board, &at);
        } else {
            going.iter().for_each(|run| end(&mut board, *run, AttemptEnd::Done));
        }
    }
    assert_eq!(lives[0], runs);
    assert_eq!(lives[1], runs, "once may be chance");
    assert!(lives[2..].iter().all(|going| going.len() == 1), "suspects go on alone: {lives:?}");
    assert_eq!(state(&board, guilty), State::Stalled);
    for run in [runs[0], runs[2]] {
        assert_eq!(state(&board, run), State::Done);
    }
    assert_eq!(lives.len(), 2 + 3 + 2, "{lives:?}");
    // What `retry` begins again is a suspect still, and three more deaths stall it again.
    let event = board.retry(guilty).expect("it may be").expect("an event");
    take(&mut board, [event]);
    let other = submit(&mut board, order("a", 0, 9));
    for life in 0..3 {
        assert_eq!(begin(&mut board), [guilty], "life {life}");
        assert_eq!(board.next(0), None, "{other} waits");
        assert_eq!(die(&mut board, &[(guilty, 70)]).len(), usize::from(life == 2));
    }
    assert_eq!(begin(&mut board), [other]);
}

#[test]
fn a_run_that_gets_on_never_ends_as_stalled_however_often_the_coordinator_is_killed() {
    let mut board = Board::default();
    let runs: Vec<u64> = (0..2).map(|at| submit(&mut board, order("a", 0, at))).collect();
    for life in 1..50 {
        assert_eq!(begin(&mut board), runs, "life {life}: no suspects");
        assert!(die(&mut board, &[(runs[0], life), (runs[1], life)]).is_empty());
    }
    // One that gets on at every third life only goes on alone at times, and goes on.
    take(&mut board, [BoardEvent::Paused { run: runs[1] }]);
    for life in 150..200 {
        assert_eq!(begin(&mut board), [runs[0]]);
        assert!(die(&mut board, &[(runs[0], life / 3)]).is_empty(), "life {life}");
    }
}

#[test]
fn a_run_that_kills_and_is_cancelled_is_cancelled() {
    let mut board = Board::default();
    let run = submit(&mut board, order("a", 0, 0));
    for _ in 0..4 {
        begin(&mut board);
        assert!(die(&mut board, &[(run, 0)]).is_empty());
    }
    begin(&mut board);
    let wish = board.cancel(run, RunEnd::default(), 0).expect("it may be");
    take(&mut board, wish);
    assert!(die(&mut board, &[(run, 0)]).is_empty());
    assert_eq!(state(&board, run), State::Cancelled);
}

#[test]
fn a_priority_beyond_its_bounds_is_refused_however_far() {
    let board = Board::default();
    for (priority, may) in [(i32::MIN, false), (-101, false), (101, false), (i32::MAX, false)]
        .into_iter()
        .chain([(-100, true), (0, true), (100, true)])
    {
        let said = board.submit(order("a", priority, 0), MAX_KEPT);
        assert_eq!(said.is_ok(), may, "{priority}");
        assert!(may || said == Err(No::Priority), "{priority}");
    }
}
