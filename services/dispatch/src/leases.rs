//! The leases of a job: one, and rarely a second, so that the first lies where the job does.

use crate::event::{Epoch, Millis, Run, Worker};

/// How far an attempt is, as its worker has said.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Stage {
    Granted,
    /// A solver has the job.
    Begun,
    /// The solver is done with it.
    Offered,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Lease {
    pub(crate) worker: Worker,
    pub(crate) epoch: Epoch,
    pub(crate) granted: Millis,
    pub(crate) expires: Millis,
    pub(crate) hard: Millis,
    pub(crate) suspect: bool,
    pub(crate) stage: Stage,
    /// It is among the slow attempts, or was.
    pub(crate) slow: bool,
    /// To whom and how much it is charged.
    pub(crate) run: Run,
    pub(crate) charged: Millis,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Leases {
    /// None only if there is no other.
    first: Option<Lease>,
    others: Vec<Lease>,
}

impl Leases {
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Lease> {
        self.first.iter().chain(&self.others)
    }

    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Lease> {
        self.first.iter_mut().chain(&mut self.others)
    }

    /// The one of that grant.
    pub(crate) fn find(&mut self, epoch: Epoch) -> Option<&mut Lease> {
        self.iter_mut().find(|lease| lease.epoch == epoch)
    }

    /// The same, if that worker has it.
    pub(crate) fn find_own(&mut self, worker: Worker, epoch: Epoch) -> Option<&mut Lease> {
        self.find(epoch).filter(|lease| lease.worker == worker)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.first.is_none()
    }

    /// The one, if there is no other.
    pub(crate) fn only(&self) -> Option<&Lease> {
        self.first.as_ref().filter(|_| self.others.is_empty())
    }

    pub(crate) fn first(&self) -> Option<&Lease> {
        self.first.as_ref()
    }

    pub(crate) fn push(&mut self, lease: Lease) {
        match self.first {
            None => self.first = Some(lease),
            Some(_) => self.others.push(lease),
        }
    }

    /// Takes out the first that is wanted.
    pub(crate) fn take(&mut self, wanted: impl Fn(&Lease) -> bool) -> Option<Lease> {
        if self.first.as_ref().is_some_and(&wanted) {
            let next = (!self.others.is_empty()).then(|| self.others.remove(0));
            return std::mem::replace(&mut self.first, next);
        }
        let at = self.others.iter().position(wanted)?;
        Some(self.others.remove(at))
    }
}

impl IntoIterator for Leases {
    type Item = Lease;
    type IntoIter = std::iter::Chain<std::option::IntoIter<Lease>, std::vec::IntoIter<Lease>>;

    fn into_iter(self) -> Self::IntoIter {
        self.first.into_iter().chain(self.others)
    }
}
