//! A worker's side of the pool as a state machine: what it asks, repeats, renews, stops, gives
//! back.
//!
//! The shell in `services/worker` feeds [`WorkerMachine::step`] what it heard and does what comes
//! back; the simulation runs the same machine. What it keeps to:
//! - one question for work at a time; a repeat of it has the same number;
//! - a result is handed in until there is a receipt, however long the coordinator is away;
//! - a solve that outlasts the hard limit is killed here, whoever else may have forgotten it;
//! - a job that nobody wants any more is killed at the next renewal;
//! - before a solver gets a job, a renewal says so;
//! - one that is to leave when idle does so once it has had no job for that long, and never with a
//!   job or a result at hand.

use crate::event::{Digest, Epoch, Job, Millis, Trouble};
#[cfg(test)]
use crate::mutant::Mutant;

/// First pause after silence \[ms\]; doubles up to [`LAST_PAUSE`].
const FIRST_PAUSE: Millis = 20;
/// Longest pause after silence, and the pause after a refusal \[ms\].
const LAST_PAUSE: Millis = 1_000;
/// Refusals of one question after which it is given up: the next would be refused too. A question
/// for work is never given up: the coordinator behind the name may change.
const MAX_REFUSALS: u32 = 5;

/// A job to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Work {
    /// The job concerned.
    pub job: Job,
    /// By which grant.
    pub epoch: Epoch,
    /// Renew this often \[ms\].
    pub renew: Millis,
    /// Kill it after this long \[ms\].
    pub hard: Millis,
}

/// A question to the coordinator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// For work.
    Poll {
        /// Its number.
        seq: u64,
    },
    /// To go on.
    Renew {
        /// At what.
        job: Job,
        /// By which grant.
        epoch: Epoch,
        /// Whether a solver has the job here.
        begun: bool,
    },
    /// To count a result.
    Commit {
        /// Of what.
        job: Job,
        /// By which grant.
        epoch: Epoch,
        /// Of the result's bytes.
        digest: Digest,
        /// The number of the question for work that goes with it.
        next: u64,
    },
    /// To take a job back.
    Fail {
        /// The job concerned.
        job: Job,
        /// By which grant.
        epoch: Epoch,
        /// What went wrong.
        trouble: Trouble,
    },
    /// To leave.
    Bye,
}

/// Something that a worker hears, from the coordinator or from its own job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WorkerInput {
    /// It has begun.
    Begin,
    /// The answer to a question for work: this.
    Grant {
        /// To which.
        seq: u64,
        /// The work that is asked for.
        work: Work,
    },
    /// The answer to a question for work: nothing now.
    Idle {
        /// To which.
        seq: u64,
    },
    /// The answer to a question for work: leave.
    Dismiss {
        /// To which.
        seq: u64,
    },
    /// The answer to a renewal: nobody wants the job.
    Stop {
        /// By which grant.
        epoch: Epoch,
    },
    /// The job's bytes are here.
    Fetched {
        /// By which grant.
        epoch: Epoch,
    },
    /// The job has a verdict.
    Solved {
        /// By which grant.
        epoch: Epoch,
        /// Of the verdict's bytes.
        digest: Digest,
    },
    /// The job died, its bytes did not come, or its result was not understood.
    Trouble {
        /// By which grant.
        epoch: Epoch,
        /// Which kind.
        trouble: Trouble,
    },
    /// A result needs no further keeping; perhaps the next job comes along.
    Receipt {
        /// By which grant.
        epoch: Epoch,
        /// The next job.
        next: Option<Work>,
    },
    /// A job given back, or a leave, was noted.
    Noted,
    /// A question stayed without an answer.
    Silence(Question),
    /// A question was refused as it is.
    Refused(Question),
    /// It is to stop.
    Quit,
    /// Time has passed.
    Tick,
}

/// Something for the worker to do, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WorkerOutput {
    /// Ask.
    Ask(Question),
    /// Get the job's bytes.
    Fetch(Work),
    /// Solve it.
    Solve(Work),
    /// End the fetch or the solve, whatever it does.
    Kill(Epoch),
    /// The end.
    Leave,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Born,
    Asking,
    Fetching(Work),
    Solving(Work),
    Handing(Work),
    Returning(Work),
    Leaving,
    Left,
}

/// A worker.
#[derive(Debug)]
pub struct WorkerMachine {
    state: State,
    seq: u64,
    /// The question that waits for an answer, or for its repeat.
    asked: Option<Question>,
    repeat: Option<Millis>,
    pause: Millis,
    refused: u32,
    renewal: Millis,
    deadline: Millis,
    /// Leave after this long without a job.
    idle_limit: Option<Millis>,
    /// Since when it has had no job; it counts while it asks for one.
    idle_since: Millis,
    quit: bool,
    #[cfg(test)]
    pub(crate) mutant: Option<Mutant>,
}

impl Default for WorkerMachine {
    fn default() -> Self {
        Self {
            state: State::Born,
            seq: 0,
            asked: None,
            repeat: None,
            pause: FIRST_PAUSE,
            refused: 0,
            renewal: 0,
            deadline: 0,
            idle_limit: None,
            idle_since: 0,
            quit: false,
            #[cfg(test)]
            mutant: None,
        }
    }
}

impl WorkerMachine {
    /// A worker that leaves once it has had no job for `limit` \[ms\].
    #[must_use]
    pub fn leaving_when_idle(limit: Millis) -> Self {
        Self { idle_limit: Some(limit), ..Self::default() }
    }

    /// When it wants to hear [`WorkerInput::Tick`] at the latest.
    #[must_use]
    pub fn wake(&self) -> Option<Millis> {
        let busy = match self.state {
            State::Fetching(_) | State::Solving(_) => Some(self.renewal.min(self.deadline)),
            State::Handing(_) | State::Returning(_) => Some(self.renewal),
            State::Born | State::Asking | State::Leaving | State::Left => None,
        };
        busy.into_iter().chain(self.repeat).chain(self.idle_end()).min()
    }

    /// When it has been without a job for long enough to leave.
    fn idle_end(&self) -> Option<Millis> {
        let asks = self.state == State::Asking;
        self.idle_limit.filter(|_| asks).map(|limit| self.idle_since.saturating_add(limit))
    }

    /// The job at hand.
    #[must_use]
    pub fn at(&self) -> Option<Work> {
        match self.state {
            State::Fetching(work)
            | State::Solving(work)
            | State::Handing(work)
            | State::Returning(work) => Some(work),
            State::Born | State::Asking | State::Leaving | State::Left => None,
        }
    }

    /// Whether it has left.
    #[must_use]
    pub fn left(&self) -> bool {
        self.state == State::Left
    }

    /// Takes in what was heard at `now` \[ms\] and says what to do about it.
    pub fn step(&mut self, now: Millis, heard: WorkerInput) -> Vec<WorkerOutput> {
        let mut out = Vec::new();
        match (heard, self.state) {
            (WorkerInput::Begin, State::Born) => self.free(now, &mut out),
            (WorkerInput::Grant { seq, work }, State::Asking) if seq == self.seq => {
                self.begin(now, work, &mut out);
            }
            (WorkerInput::Idle { seq }, State::Asking) if seq == self.seq => self.next(&mut out),
            (WorkerInput::Dismiss { seq }, State::Asking) if seq == self.seq => {
                self.leave(&mut out);
            }
            (WorkerInput::Stop { epoch }, State::Fetching(work) | State::Solving(work))
                if epoch == work.epoch =>
            {
                out.push(WorkerOutput::Kill(epoch));
                self.free(now, &mut out);
            }
            (WorkerInput::Fetched { epoch }, State::Fetching(work)) if epoch == work.epoch => {
                self.state = State::Solving(work);
                // Said before it can take this process with it.
                self.renew(now, work, &mut out);
                out.push(WorkerOutput::Solve(work));
            }
            (WorkerInput::Solved { epoch, digest }, State::Solving(work))
                if epoch == work.epoch =>
            {
                self.state = State::Handing(work);
                self.seq += 1;
                let (job, next) = (work.job, self.seq);
                self.ask(Question::Commit { job, epoch, digest, next }, &mut out);
            }
            (
                WorkerInput::Trouble { epoch, trouble },
                State::Fetching(work) | State::Solving(work) | State::Handing(work),
            ) if epoch == work.epoch => self.give_back(work, trouble, &mut out),
            (WorkerInput::Receipt { epoch, next }, State::Handing(work)) if epoch == work.epoch => {
                match next.filter(|_| !self.quit) {
                    Some(next) => self.begin(now, next, &mut out),
                    None => self.free(now, &mut out),
                }
            }
            (WorkerInput::Noted, State::Returning(_)) => self.free(now, &mut out),
            (WorkerInput::Noted, State::Leaving) => self.end(&mut out),
            (WorkerInput::Silence(question), _) if self.asked == Some(question) => {
                self.unanswered(now, &mut out);
            }
            (WorkerInput::Refused(question), _) if self.asked == Some(question) => {
                self.refuse(now, question, &mut out);
            }
            (WorkerInput::Quit, _) => self.stop(&mut out),
            (WorkerInput::Tick, _) => self.tick(now, &mut out),
            // Late, twice, or of another job: nothing to do with what is at hand.
            (
                WorkerInput::Begin
                | WorkerInput::Grant { .. }
                | WorkerInput::Idle { .. }
                | WorkerInput::Dismiss { .. }
                | WorkerInput::Stop { .. }
                | WorkerInput::Fetched { .. }
                | WorkerInput::Solved { .. }
                | WorkerInput::Trouble { .. }
                | WorkerInput::Receipt { .. }
                | WorkerInput::Noted
                | WorkerInput::Silence(_)
                | WorkerInput::Refused(_),
                _,
            ) => {}
        }
        out
    }

    fn ask(&mut self, question: Question, out: &mut Vec<WorkerOutput>) {
        (self.asked, self.repeat) = (Some(question), None);
        (self.pause, self.refused) = (FIRST_PAUSE, 0);
        out.push(WorkerOutput::Ask(question));
    }

    /// Has no job any more, or none yet.
    fn free(&mut self, now: Millis, out: &mut Vec<WorkerOutput>) {
        self.idle_since = now;
        self.next(out);
    }

    /// Asks for work, or leaves if it is to stop.
    fn next(&mut self, out: &mut Vec<WorkerOutput>) {
        if self.quit {
            return self.leave(out);
        }
        self.seq += 1;
        self.state = State::Asking;
        self.ask(Question::Poll { seq: self.seq }, out);
    }

    fn begin(&mut self, now: Millis, work: Work, out: &mut Vec<WorkerOutput>) {
        self.state = State::Fetching(work);
        (self.asked, self.repeat) = (None, None);
        (self.renewal, self.deadline) = (now + work.renew, now + work.hard);
        out.push(WorkerOutput::Fetch(work));
    }

    fn give_back(&mut self, work: Work, trouble: Trouble, out: &mut Vec<WorkerOutput>) {
        self.state = State::Returning(work);
        self.ask(Question::Fail { job: work.job, epoch: work.epoch, trouble }, out);
    }

    fn leave(&mut self, out: &mut Vec<WorkerOutput>) {
        self.state = State::Leaving;
        self.ask(Question::Bye, out);
    }

    fn end(&mut self, out: &mut Vec<WorkerOutput>) {
        self.state = State::Left;
        (self.asked, self.repeat) = (None, None);
        out.push(WorkerOutput::Leave);
    }

    fn stop(&mut self, out: &mut Vec<WorkerOutput>) {
        self.quit = true;
        match self.state {
            State::Born => self.end(out),
            State::Asking => self.leave(out),
            State::Fetching(work) | State::Solving(work) => {
                out.push(WorkerOutput::Kill(work.epoch));
                self.leave(out);
            }
            // What is being asked gets one more chance.
            State::Handing(_) | State::Returning(_) | State::Leaving | State::Left => {}
        }
    }

    fn unanswered(&mut self, now: Millis, out: &mut Vec<WorkerOutput>) {
        if self.quit {
            return match self.state {
                State::Leaving => self.end(out),
                _ => self.leave(out),
            };
        }
        #[cfg(test)]
        if self.mutant == Some(Mutant::ResultForgotten)
            && let State::Handing(_) = self.state
        {
            return self.free(now, out);
        }
        self.repeat = Some(now + self.pause);
        self.pause = (self.pause * 2).min(LAST_PAUSE);
    }

    fn refuse(&mut self, now: Millis, question: Question, out: &mut Vec<WorkerOutput>) {
        self.refused += 1;
        let poll = matches!(question, Question::Poll { .. });
        if self.quit || (self.refused >= MAX_REFUSALS && !poll) {
            return match self.state {
                State::Leaving => self.end(out),
                State::Asking => self.next(out),
                _ => self.free(now, out),
            };
        }
        self.repeat = Some(now + LAST_PAUSE);
    }

    fn tick(&mut self, now: Millis, out: &mut Vec<WorkerOutput>) {
        if self.idle_end().is_some_and(|end| end <= now) {
            self.quit = true;
            return self.leave(out);
        }
        if let (Some(at), Some(question)) = (self.repeat, self.asked)
            && at <= now
        {
            self.repeat = None;
            out.push(WorkerOutput::Ask(question));
        }
        let Some(work) = self.at() else {
            return;
        };
        #[cfg(test)]
        let late = self.deadline <= now && self.mutant != Some(Mutant::NoWatchdog);
        #[cfg(not(test))]
        let late = self.deadline <= now;
        if late && let State::Fetching(_) | State::Solving(_) = self.state {
            out.push(WorkerOutput::Kill(work.epoch));
            let solving = matches!(self.state, State::Solving(_));
            let trouble = if solving { Trouble::Crashed } else { Trouble::Dropped };
            return self.give_back(work, trouble, out);
        }
        if self.renewal <= now {
            self.renew(now, work, out);
        }
    }

    fn renew(&mut self, now: Millis, work: Work, out: &mut Vec<WorkerOutput>) {
        let Work { job, epoch, renew, .. } = work;
        let begun = matches!(self.state, State::Solving(_));
        self.renewal = now + renew;
        out.push(WorkerOutput::Ask(Question::Renew { job, epoch, begun }));
    }
}
