//! A router alone: what coordinators, workers and clients connect to, where none of them is to be
//! reached itself. It keeps nothing: it may be killed and started again at any time.

use super::{LinkError, net};
use cullet_proto::security::Rules;
use cullet_proto::transport::Patience;
use zenoh::Wait;

/// A router that goes on until it is dropped.
pub struct Router {
    session: zenoh::Session,
    endpoint: String,
}

impl Router {
    /// Listens on an endpoint, with an identity and roles.
    ///
    /// # Errors
    /// [`LinkError::Listen`].
    pub fn start(listen: &str, rules: &Rules) -> Result<Self, LinkError> {
        let (session, endpoint) = net::listening(listen, Patience::production(), rules)?;
        Ok(Self { session, endpoint })
    }

    /// Where it is.
    #[must_use]
    pub fn endpoint(&self) -> &str {
        &self.endpoint
    }
}

impl Drop for Router {
    fn drop(&mut self) {
        if let Err(error) = self.session.close().wait() {
            tracing::debug!("closing the router: {error}");
        }
    }
}
