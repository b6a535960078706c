//! From a plan to a package: the driver.
