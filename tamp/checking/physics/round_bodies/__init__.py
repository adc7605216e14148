"""What is round, and what stands on it: does it perch, rock or roll?"""
