//! Fair shares: which run's job goes next.
//!
//! Two levels of stride scheduling. Each tenant, and within it each run, has a *pass*: worker time
//! \[ms\] charged so far over its weight. The lowest pass with work goes next; ties go to the lower
//! number. One that comes back with work starts where the others are, so idleness saves nothing up.
//! A job is charged its run's mean time when it is granted, and the difference when it ends.
//! Ageing: a run that has had work and no grant for [`Timing::age`](crate::Timing::age) lets one
//! other pass and goes next, so that no priority starves another. All in integers.

use crate::ask::Ask;
use crate::counts::Counts;
use crate::event::{Job, Millis, Run, Share, Tenant};
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Passes are charged in 2⁻¹⁰ ms, so that the highest priority still moves.
const SCALE: u32 = 10;
/// Time that a job of a run is charged before one has ended \[ms\].
const FIRST_GUESS: Millis = 1_000;
/// Attempts whose times are kept for the median.
const TIMES: usize = 32;
/// Fewer finished attempts tell no median.
const ENOUGH: usize = 3;

/// What is kept of a run.
#[derive(Debug)]
pub(crate) struct Account {
    share: Share,
    pass: u64,
    /// Jobs that may be granted, by what they ask of a worker and by opening; no empty one.
    ready: BTreeMap<Ask, BTreeMap<u64, Job>>,
    /// Unsettled openings, in order; the first has the number `counts.settled`.
    pub(crate) openings: VecDeque<Job>,
    paused: bool,
    /// In line since, if it is in line.
    since: Option<Millis>,
    /// It has waited too long, and could have gone, and another has: it goes next.
    passed: bool,
    guess: Millis,
    times: VecDeque<Millis>,
    pub(crate) counts: Counts,
}

#[derive(Debug, Default)]
struct TenantQueue {
    pass: u64,
    /// Pass of the run that went last: where a run that comes back starts.
    clock: u64,
    line: BTreeSet<(u64, Run)>,
    runs: u64,
}

/// The books of the runs and the line in which they stand.
#[derive(Debug, Default)]
pub(crate) struct Shares {
    accounts: BTreeMap<Run, Account>,
    tenants: BTreeMap<Tenant, TenantQueue>,
    line: BTreeSet<(u64, Tenant)>,
    waiting: BTreeSet<(Millis, Run)>,
    clock: u64,
}

impl Shares {
    pub(crate) fn begin(&mut self, now: Millis, run: Run, mut share: Share) {
        share.priority = share.priority.min(Share::HIGHEST);
        self.tenants.entry(share.tenant).or_default().runs += 1;
        if self.accounts.contains_key(&run) {
            self.delist(run);
            if let Some(account) = self.accounts.get_mut(&run) {
                let old = std::mem::replace(&mut account.share, share);
                // A pass means nothing in another queue.
                account.pass = if old.tenant == share.tenant { account.pass } else { 0 };
                self.leave(old.tenant);
            }
            return self.enlist(now, run);
        }
        let account = Account {
            share,
            pass: 0,
            ready: BTreeMap::new(),
            openings: VecDeque::new(),
            paused: false,
            since: None,
            passed: false,
            guess: FIRST_GUESS,
            times: VecDeque::new(),
            counts: Counts::default(),
        };
        self.accounts.insert(run, account);
    }

    /// Forgets a run, whose openings are settled.
    pub(crate) fn end(&mut self, run: Run) {
        self.delist(run);
        if let Some(account) = self.accounts.remove(&run) {
            self.leave(account.share.tenant);
        }
    }

    fn leave(&mut self, tenant: Tenant) {
        if let Some(queue) = self.tenants.get_mut(&tenant) {
            queue.runs -= 1;
            if queue.runs == 0 {
                self.tenants.remove(&tenant);
            }
        }
    }

    pub(crate) fn get(&self, run: Run) -> Option<&Account> {
        self.accounts.get(&run)
    }

    pub(crate) fn get_mut(&mut self, run: Run) -> Option<&mut Account> {
        self.accounts.get_mut(&run)
    }

    pub(crate) fn pause(&mut self, now: Millis, run: Run, paused: bool) {
        if let Some(account) = self.accounts.get_mut(&run) {
            account.paused = paused;
        }
        if paused {
            self.delist(run);
        } else {
            self.enlist(now, run);
        }
    }

    /// This job of the run may be granted.
    pub(crate) fn ready(&mut self, now: Millis, run: Run, ask: &Ask, (opening, job): (u64, Job)) {
        if let Some(account) = self.accounts.get_mut(&run) {
            match account.ready.get_mut(ask) {
                Some(line) => drop(line.insert(opening, job)),
                None => drop(account.ready.insert(ask.clone(), [(opening, job)].into())),
            }
        }
        self.enlist(now, run);
    }

    /// This job of the run may not be granted any more.
    pub(crate) fn unready(&mut self, run: Run, ask: &Ask, opening: u64) {
        let Some(account) = self.accounts.get_mut(&run) else {
            return;
        };
        let Some(line) = account.ready.get_mut(ask) else {
            return;
        };
        line.remove(&opening);
        if line.is_empty() {
            account.ready.remove(ask);
            if account.ready.is_empty() {
                self.delist(run);
            }
        }
    }

    /// Whose job goes next, and which, of those that somebody may be given. Runs without such a one
    /// are passed over, one by one.
    pub(crate) fn pick(
        &mut self,
        now: Millis,
        age: Millis,
        somebody: impl Fn(&Ask) -> bool,
    ) -> Option<(Run, Job)> {
        let asks = |account: &Account| account.ready.keys().any(&somebody);
        let can = |run: &Run| self.accounts.get(run).is_some_and(asks);
        let of = |tenant: &Tenant| self.tenants.get(tenant)?.line.iter().find(|(_, run)| can(run));
        let first = self.line.iter().find_map(|(at, tenant)| Some((*at, *tenant, *of(tenant)?)));
        let (at, tenant, (pass, mut run)) = first?;
        let mut late =
            self.waiting.iter().take_while(|(since, _)| since.saturating_add(age) <= now);
        match late.find(|(_, run)| can(run)).copied() {
            Some((_, starved)) if self.accounts.get(&starved).is_some_and(|a| a.passed) => {
                run = starved;
            }
            other => {
                let starved = other.and_then(|(_, run)| self.accounts.get_mut(&run));
                starved.into_iter().for_each(|account| account.passed = true);
                self.clock = self.clock.max(at);
                if let Some(queue) = self.tenants.get_mut(&tenant) {
                    queue.clock = queue.clock.max(pass);
                }
            }
        }
        let able = self.accounts.get(&run)?.ready.iter();
        let able = able.filter(|(ask, _)| somebody(ask));
        let (_, job) = able.filter_map(|(_, line)| line.first_key_value()).min()?;
        Some((run, *job))
    }

    /// Charges an attempt: returns what was charged \[ms\]. With a grant the run's waiting begins
    /// anew; with a duplicate, or a lease taken up again, it goes on.
    pub(crate) fn charge(&mut self, now: Millis, run: Run, grant: bool) -> Millis {
        let Some(guess) = self.accounts.get(&run).map(|account| account.guess.max(1)) else {
            return 0;
        };
        let since = self.delist(run);
        if let Some(account) = self.accounts.get_mut(&run).filter(|_| grant) {
            account.passed = false;
        }
        self.book(run, |pass, shift| pass + ((guess << SCALE) >> shift));
        self.put(since.filter(|_| !grant).unwrap_or(now), run);
        guess
    }

    /// An attempt that was charged so much took so long; `whole`: it came to a result.
    pub(crate) fn took(&mut self, run: Run, charged: Millis, took: Millis, whole: bool) {
        let since = self.delist(run);
        self.book(run, |pass, shift| {
            (pass + ((took << SCALE) >> shift)).saturating_sub((charged << SCALE) >> shift)
        });
        if let Some(account) = self.accounts.get_mut(&run)
            && whole
        {
            account.guess = (account.guess * 7 + took) / 8;
            account.times.push_back(took);
            if account.times.len() > TIMES {
                account.times.pop_front();
            }
        }
        if let Some(since) = since {
            self.put(since, run);
        }
    }

    /// The median time of the run's attempts, once there are enough \[ms\].
    pub(crate) fn median(&self, run: Run) -> Option<Millis> {
        let mut times: Vec<_> = self.accounts.get(&run)?.times.iter().copied().collect();
        times.sort_unstable();
        (times.len() >= ENOUGH).then(|| times[times.len() / 2])
    }

    /// Moves the passes of a run that is not in line, and of its tenant, who may be.
    fn book(&mut self, run: Run, moved: impl Fn(u64, u32) -> u64) {
        let Some(account) = self.accounts.get_mut(&run) else {
            return;
        };
        account.pass = moved(account.pass, u32::from(account.share.priority));
        let tenant = account.share.tenant;
        if let Some(queue) = self.tenants.get_mut(&tenant) {
            let in_line = self.line.remove(&(queue.pass, tenant));
            queue.pass = moved(queue.pass, 0);
            if in_line {
                self.line.insert((queue.pass, tenant));
            }
        }
    }

    /// Puts a run that comes with work into the line, no further ahead than the others are.
    fn enlist(&mut self, now: Millis, run: Run) {
        let Some(account) = self.accounts.get_mut(&run) else {
            return;
        };
        if account.since.is_some() {
            return;
        }
        if let Some(queue) = self.tenants.get_mut(&account.share.tenant) {
            account.pass = account.pass.max(queue.clock);
            if queue.line.is_empty() {
                queue.pass = queue.pass.max(self.clock);
            }
        }
        self.put(now, run);
    }

    /// Puts a run into the line where its pass says, if it has work.
    fn put(&mut self, now: Millis, run: Run) {
        let Some(account) = self.accounts.get_mut(&run) else {
            return;
        };
        if account.paused || account.ready.is_empty() || account.since.is_some() {
            return;
        }
        let tenant = account.share.tenant;
        let Some(queue) = self.tenants.get_mut(&tenant) else {
            return;
        };
        account.since = Some(now);
        self.waiting.insert((now, run));
        self.line.insert((queue.pass, tenant));
        queue.line.insert((account.pass, run));
    }

    /// Takes a run out of the line; since when it was in it.
    fn delist(&mut self, run: Run) -> Option<Millis> {
        let account = self.accounts.get_mut(&run)?;
        let since = account.since.take()?;
        self.waiting.remove(&(since, run));
        let tenant = account.share.tenant;
        let queue = self.tenants.get_mut(&tenant)?;
        queue.line.remove(&(account.pass, run));
        if queue.line.is_empty() {
            self.line.remove(&(queue.pass, tenant));
        }
        Some(since)
    }
}
