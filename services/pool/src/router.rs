//! A router alone: what coordinators, workers and clients connect to, where none of them is to be
//! reached itself. It keeps nothing: it may be killed and started again at any time.

use super::error::LinkError;
use super::net;
use cullet_proto::security::Rules;
use cullet_proto::transport::{self, Patience};
use serde_json::{Map, Value};
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

/// The settings of such a router as a file that `zenohd -c` reads: with the places of the identity
/// as they were given, and all of the access control.
///
/// # Errors
/// [`LinkError::Listen`] for a setting that is no JSON.
pub fn config(listen: &str, rules: &Rules) -> Result<String, LinkError> {
    let mut all = Value::Object(Map::new());
    let settings = transport::router(listen, Patience::production());
    for (path, value) in settings.iter().chain(rules) {
        let mut place = &mut all;
        for step in path.split('/') {
            place = &mut place[step];
        }
        *place = serde_json::from_str(value).map_err(|error| LinkError::Listen {
            endpoint: listen.to_owned(),
            text: format!("{path} = {value}: {error}"),
        })?;
    }
    Ok(format!("{all:#}\n"))
}

impl Drop for Router {
    fn drop(&mut self) {
        if let Err(error) = self.session.close().wait() {
            tracing::debug!("closing the router: {error}");
        }
    }
}
