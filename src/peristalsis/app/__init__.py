"""The browser app: a page on this machine that shows runs while they compute, and takes changes on the way."""
