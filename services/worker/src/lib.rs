//! The worker: asks for jobs, hosts a solver in slices, hands results back.
