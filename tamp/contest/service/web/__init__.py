"""The service on the web: pages for people, the same for programs, and how connections are kept prompt."""
