"""Put one tab's page together and serve it to browsers."""
