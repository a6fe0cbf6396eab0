use super::Keeper;
use crate::link::{Ending, Settlement};
use crate::run::{Jobs, Load};
use crate::service::live::Live;
use crate::service::store::Store;
use cullet_proto::{FractureJob, JobId, Verdict};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::time::Duration;

/// A pool that answers at once and counts what it was asked.
#[derive(Default)]
struct Stub {
    open: RefCell<VecDeque<JobId>>,
    asked: RefCell<Vec<JobId>>,
}

impl Jobs for Stub {
    fn open(&self, job: &FractureJob) -> JobId {
        let id = JobId::of(&job.encode().expect("a job"));
        self.open.borrow_mut().push_back(id);
        self.asked.borrow_mut().push(id);
        id
    }

    fn settled(&self, _: Duration) -> Option<(JobId, Settlement)> {
        let id = self.open.borrow_mut().pop_front()?;
        let verdict = Verdict::Refused { solver: "stub".into(), text: id.short() };
        let (ending, worker) = (Ending::Verdict(verdict), "w".to_owned());
        let (wall, tries) = (Duration::ZERO, Vec::new());
        Some((
            id,
            Settlement {
                ending,
                attempts: 1,
                worker,
                wall,
                cached: false,
                tries,
                reproduction: None,
            },
        ))
    }

    fn load(&self) -> Load {
        Load::default()
    }

    fn cancel(&self) {
        self.open.borrow_mut().clear();
    }
}

fn job(seed: u64) -> FractureJob {
    FractureJob::smallest("stub", seed)
}

#[test]
fn what_a_run_does_not_want_any_more_the_pool_hears_of() {
    let (pool, live) = (Stub::default(), Live::default());
    let keeper = Keeper::new(&pool, None, &live);
    keeper.open(&job(1));
    assert_eq!(pool.open.borrow().len(), 1);
    keeper.cancel();
    assert!(pool.open.borrow().is_empty() && keeper.settled(Duration::ZERO).is_none());
}

#[test]
fn a_second_attempt_asks_the_pool_for_what_is_new_alone_and_hears_the_same_in_order() {
    let (store, pool) = (Store::open(None).expect("a folder"), Stub::default());
    let live = Live::default();
    let attempt = |wanted: &[u64], settle: usize| {
        let keeper = Keeper::new(&pool, Some(store.kept(1)), &live);
        let ids: Vec<JobId> = wanted.iter().map(|seed| keeper.open(&job(*seed))).collect();
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
