use super::{ReplayingPool, ReportingPool};
use crate::run_status::RunStatus;
use crate::store::Store;
use crate::timeline::{RunHistory, svg, trace};
use cullet_pool::{Attempted, JobEnding, Settlement};
use cullet_proto::{FractureJob, JobId, Verdict};
use cullet_run::{JobPool, PoolLoad, WantedJob};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// A pool that answers at once and counts what it was asked.
#[derive(Default)]
struct Stub {
    open: RefCell<VecDeque<JobId>>,
    news: RefCell<Vec<Attempted>>,
    asked: RefCell<Vec<JobId>>,
}

impl JobPool for Stub {
    fn open(&self, job: WantedJob<'_>) -> JobId {
        let id = JobId::of(&job.encode().expect("a job"));
        self.open.borrow_mut().push_back(id);
        self.asked.borrow_mut().push(id);
        id
    }

    fn settled(&self, _: Duration) -> Option<(JobId, Settlement)> {
        let id = self.open.borrow_mut().pop_front()?;
        let verdict = Verdict::Refused { solver: "stub".into(), text: id.short() };
        let (ending, worker) = (JobEnding::Verdict(verdict), "w".to_owned());
        let (wall, tries) = (Duration::ZERO, Vec::new());
        Some((
            id,
            Settlement {
                ending,
                attempts: 1,
                worker,
                wall,
                cached: false,
                overdue: false,
                tries,
                reproduction: None,
            },
        ))
    }

    fn load(&self) -> PoolLoad {
        PoolLoad::default()
    }

    fn cancel(&self) {
        self.open.borrow_mut().clear();
    }
}

impl ReportingPool for Stub {
    fn attempts(&self) -> Vec<Attempted> {
        self.news.take()
    }
}

fn job(seed: u64) -> FractureJob {
    FractureJob::smallest("stub", seed)
}

#[test]
fn what_a_run_does_not_want_any_more_the_pool_hears_of() {
    let (pool, live) = (Stub::default(), RunStatus::default());
    let keeper = ReplayingPool::new(&pool, None, &live);
    keeper.open(WantedJob::Fracture(&job(1)));
    assert_eq!(pool.open.borrow().len(), 1);
    keeper.cancel();
    assert!(pool.open.borrow().is_empty() && keeper.settled(Duration::ZERO).is_none());
}

#[test]
fn a_second_attempt_asks_the_pool_for_what_is_new_alone_and_hears_the_same_in_order() {
    let (store, pool) = (Store::open(None).expect("a folder"), Stub::default());
    let live = RunStatus::default();
    let attempt = |wanted: &[u64], settle: usize| {
        let kept = store.kept(1);
        let keeper = ReplayingPool::new(&pool, Some(&kept), &live);
        let ids: Vec<JobId> =
            wanted.iter().map(|seed| keeper.open(WantedJob::Fracture(&job(*seed)))).collect();
        let heard: Vec<_> = (0..settle).filter_map(|_| keeper.settled(Duration::ZERO)).collect();
        assert!(heard.iter().map(|(id, _)| *id).eq(ids[..settle].iter().copied()));
        heard.into_iter().map(|(_, settled)| settled.ending).collect::<Vec<_>>()
    };
    let first = attempt(&[1, 2, 3], 2);
    assert_eq!(pool.asked.borrow().len(), 3);
    pool.open.borrow_mut().clear();
    let second = attempt(&[1, 2, 3, 4], 4);
    assert_eq!(second[..2], first);
    let asked = pool.asked.borrow()[3..].to_vec();
    assert_eq!(asked.len(), 2, "jobs 1 and 2 were settled before");
    assert_eq!(live.jobs().kept, 2);
    assert_eq!((live.jobs().opened, live.jobs().settled), (4, 4));
}

#[test]
fn who_was_at_what_has_not_settled_is_in_the_timeline_also_of_a_life_that_ended() {
    let (folder, pool, live) =
        (tempfile::tempdir().expect("a folder"), Stub::default(), RunStatus::default());
    let past = RunHistory::begin(folder.path(), 1, 10_000, None);
    let keeper = ReplayingPool::new(&pool, None, &live).noting(&past);
    let (first, second) =
        (keeper.open(WantedJob::Fracture(&job(1))), keeper.open(WantedJob::Fracture(&job(2))));
    // Nothing settles; the first is lost with its worker, and it gets it again.
    let tell = |job, (grant, worker): (u64, &str), after: u64, lost: Option<&str>| Attempted {
        job,
        grant,
        worker: worker.to_owned(),
        at: Instant::now() + Duration::from_secs(after),
        lost: lost.map(str::to_owned),
    };
    pool.news.replace(vec![
        tell(first, (1, "a"), 0, None),
        tell(second, (2, "b"), 1, None),
        tell(first, (1, "a"), 2, Some("Crashed")),
        tell(first, (3, "a"), 3, None),
        // Told again, as the run wants it once more.
        tell(first, (1, "a"), 0, None),
        tell(first, (1, "a"), 2, Some("Crashed")),
        tell(first, (3, "a"), 3, None),
    ]);
    keeper.hear();
    // The coordinator dies 7 s after the run began. Its next life has all of it.
    let next = RunHistory::begin(folder.path(), 2, 60_000, Some(17_000));
    let told: serde_json::Value =
        serde_json::from_str(&trace("pot", &next.timeline(Vec::new()))).expect("JSON");
    let events = told["traceEvents"].as_array().expect("events");
    let rows: Vec<&str> = events
        .iter()
        .filter(|event| event["name"] == "thread_name")
        .filter_map(|event| event["args"]["name"].as_str())
        .collect();
    assert_eq!(rows, ["a", "b", "the run"]);
    let bars = events.iter().filter(|event| event["cat"] == "job");
    let bar = |event: &serde_json::Value| {
        let seconds = |key: &str| (event[key].as_f64().unwrap_or(f64::NAN) / 1e6).round();
        let row = rows[event["tid"].as_u64().unwrap_or(9) as usize].to_owned();
        let ending = event["args"]["ending"].as_str().unwrap_or_default().to_owned();
        let attempts = event["args"]["attempts"].as_u64();
        (row, seconds("ts"), seconds("dur"), ending, attempts)
    };
    let cut = |row: &str, from, took, attempts| {
        (row.to_owned(), from, took, "cut off".to_owned(), Some(attempts))
    };
    let lost = ("a".to_owned(), 0.0, 2.0, "lost".to_owned(), Some(2));
    let due = [lost, cut("a", 3.0, 4.0, 2), cut("b", 1.0, 6.0, 1)];
    // Jobs come by id.
    let mut found: Vec<_> = bars.map(bar).collect();
    found.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    assert_eq!(found, due);
    let picture = svg("pot", &next.timeline(Vec::new()));
    assert!(!picture.contains("nobody") && picture.contains(" at b "), "{picture}");
    // So has a run that is over with jobs that had not settled.
    keeper.close();
    let left = live.timeline();
    assert_eq!(left.iter().map(|job| job.tries.len()).collect::<Vec<_>>(), [2, 1]);
    assert!(left.iter().all(|job| job.tries.last().is_some_and(|one| one.to == job.settled)));
}
