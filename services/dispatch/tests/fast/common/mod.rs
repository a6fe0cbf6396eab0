//! A pool of the machine alone, with a clock that the test moves.

use cullet_dispatch::*;

pub(crate) struct Pool {
    pub(crate) machine: Dispatch,
    pub(crate) now: Millis,
    pub(crate) seq: u64,
}

pub(crate) fn job(k: u64) -> Job {
    let mut name = [0; 32];
    name[..8].copy_from_slice(&k.to_be_bytes());
    Job(name)
}

impl Pool {
    pub(crate) fn new() -> Self {
        Self { machine: Dispatch::new(Timing::test(), 1), now: 0, seq: 0 }
    }

    pub(crate) fn step(&mut self, event: Event) -> Vec<Effect> {
        self.machine.step(self.now, event)
    }

    pub(crate) fn begin(&mut self, run: u64, tenant: u64, priority: u8) {
        let share = Share { tenant: Tenant(tenant), priority };
        self.step(Event::Begin { run: Run(run), share });
    }

    pub(crate) fn open(&mut self, run: u64, k: u64) -> Vec<Effect> {
        self.step(opening(run, k))
    }

    /// The same, of a job that starts from another's result.
    pub(crate) fn open_after(&mut self, run: u64, k: u64, before: u64) -> Vec<Effect> {
        let mut event = opening(run, k);
        if let Event::Open { after, .. } = &mut event {
            *after = Some(job(before));
        }
        self.step(event)
    }

    /// A worker asks; what it gets.
    pub(crate) fn ask(&mut self, worker: u64) -> Option<(Job, Epoch)> {
        self.seq += 1;
        let (worker, seq) = (Worker(worker), self.seq);
        let said = self.step(poll(worker, seq, Skills::ALL));
        granted(&said, worker)
    }

    /// The same, of a worker that is called so.
    pub(crate) fn ask_as(&mut self, name: u64, worker: u64) -> Option<(Job, Epoch)> {
        self.seq += 1;
        let worker = Worker(worker);
        let said = self.step(poll_as(name, worker, self.seq));
        granted(&said, worker)
    }

    pub(crate) fn done(&mut self, worker: u64, (job, epoch): (Job, Epoch)) -> Vec<Effect> {
        let (worker, digest, outcome) = (Worker(worker), Digest(job.0), Outcome::Broken);
        let (build, prior) = (BUILD, Prior::Nothing);
        let name = own_name(worker);
        self.step(Event::Commit { worker, name, job, epoch, build, digest, outcome, prior })
    }

    pub(crate) fn renew(&mut self, worker: u64, (job, epoch): (Job, Epoch)) {
        self.step(renewal(worker, (job, epoch), true));
    }

    pub(crate) fn pass(&mut self, time: Millis) -> Vec<Effect> {
        self.now += time;
        self.step(Event::Tick)
    }
}

pub(crate) fn opening(run: u64, k: u64) -> Event {
    let (need, prior) = (Skills::NONE, Prior::Nothing);
    Event::Open { run: Run(run), job: job(k), need, after: None, prior }
}

pub(crate) const BUILD: Build = Build([1; 32]);

pub(crate) fn renewal(worker: u64, (job, epoch): (Job, Epoch), begun: bool) -> Event {
    let (worker, build, skills) = (Worker(worker), BUILD, Skills::ALL);
    Event::Renew { worker, job, epoch, begun, build, skills, name: own_name(worker) }
}

pub(crate) fn poll(worker: Worker, seq: u64, skills: Skills) -> Event {
    let name = own_name(worker);
    Event::Poll { worker, seq, slots: 1, park: true, build: BUILD, skills, name }
}

/// The name of a worker of which the test says nothing else.
fn own_name(worker: Worker) -> WorkerName {
    WorkerName(worker.0)
}

/// The question of a worker that is called so.
pub(crate) fn poll_as(called: u64, worker: Worker, seq: u64) -> Event {
    let mut event = poll(worker, seq, Skills::ALL);
    if let Event::Poll { name, .. } = &mut event {
        *name = WorkerName(called);
    }
    event
}

pub(crate) fn granted(said: &[Effect], to: Worker) -> Option<(Job, Epoch)> {
    said.iter().find_map(|effect| match effect {
        Effect::Grant { worker, job, epoch, .. } if *worker == to => Some((*job, *epoch)),
        _ => None,
    })
}
