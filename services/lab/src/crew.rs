//! Work that several do at once and that is reported in its order.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

/// Does `count` pieces of work, `workers` of them at once; `done` gets what came of each, in
/// their order.
pub(super) fn in_order<T: Send>(
    count: usize,
    workers: usize,
    work: &(dyn Fn(usize) -> T + Sync),
    done: &mut dyn FnMut(usize, T),
) {
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        let (tell, told) = mpsc::channel::<(usize, T)>();
        for _ in 0..workers.clamp(1, count.max(1)) {
            let (tell, next) = (tell.clone(), &next);
            scope.spawn(move || {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= count || tell.send((index, work(index))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(tell);
        let (mut early, mut due) = (BTreeMap::new(), 0);
        for (index, result) in told {
            early.insert(index, result);
            while let Some(result) = early.remove(&due) {
                done(due, result);
                due += 1;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::in_order;
    use std::sync::{Mutex, mpsc};
    use std::time::Duration;

    /// The first is over only once the third is at work: others go on beside it, and are reported
    /// after it.
    #[test]
    fn work_is_done_at_once_and_told_in_order() {
        let (say, heard) = mpsc::channel::<()>();
        let (say, heard) = (Mutex::new(say), Mutex::new(heard));
        let work = |index: usize| match index {
            0 => heard.lock().is_ok_and(|it| it.recv_timeout(Duration::from_secs(20)).is_ok()),
            2 => say.lock().is_ok_and(|it| it.send(()).is_ok()),
            _ => true,
        };
        let mut told = Vec::new();
        in_order(4, 2, &work, &mut |index, good| told.push((index, good)));
        assert_eq!(told, [(0, true), (1, true), (2, true), (3, true)]);
        in_order(0, 2, &|_| (), &mut |_, ()| panic!("nothing to tell"));
    }
}
