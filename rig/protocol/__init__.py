"""The experiment as data: read, checked, varied over its grid."""
